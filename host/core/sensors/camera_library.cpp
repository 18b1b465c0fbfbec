// The built-in cameras: calibrations whose licence permits restating their numbers, one line each.
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/sensors/camera.hpp"

namespace simuli {
namespace {

using K = LensKind;

struct Source {
  const char* text;
  double first_pixel_centre;  // px, convention of cx and cy in the table
  ShutterKind shutter;
};
constexpr Source kPandaset{
    "PandaSet (CC BY 4.0), as in georghess/neurad-studio pandaset_extrinsics.yaml (Apache-2.0)",
    0.0,
    ShutterKind::kTopToBottom};
constexpr Source kTumVi{
    "TUM VI visual-inertial dataset (CC BY 4.0), Kalibr calibration", 0.0, ShutterKind::kGlobal};
constexpr Source kBasalt{
    "VladyslavUsenko/basalt data/*_calib.json (BSD-3-Clause)", 0.0, ShutterKind::kGlobal};
constexpr Source kDgp{"TRI-ML/dgp tests/data/dgp/test_scene (MIT)", 0.0, ShutterKind::kGlobal};
constexpr Source kGsplat{
    "nerfstudio-project/gsplat tests/sensors/test_data (Apache-2.0), the lens alone where a windshield "
    "was modelled too",
    0.5,
    ShutterKind::kTopToBottom};

struct Row {
  const char* name;
  const Source& source;
  LensKind kind;
  int width, height;      // px
  double fx, fy, cx, cy;  // px; F-theta: fx, fy are 1 and the polynomial gives pixels
  /// In the order of lens_parameter_names(), without max_angle_rad; missing ones are 0.
  std::array<double, 12> parameters;
  double max_angle;  // rad; pi: only the polynomials' own limit
};

// clang-format off
constexpr Row kRows[] = {
    {"pandaset_back_camera", kPandaset, K::kOpencvPinhole, 1920, 1080, 933.4667, 934.6754, 896.4692,
     507.3557, {-0.1619, 0.0113, -0.00028815, -7.9827e-05, 0.0067}, kPi},
    {"pandaset_front_camera", kPandaset, K::kOpencvPinhole, 1920, 1080, 1970.0131, 1970.0091, 970.0002,
     483.2988, {-0.5894, 0.66, 0.0011, -0.001, -1.0088}, kPi},
    {"pandaset_front_left_camera", kPandaset, K::kOpencvPinhole, 1920, 1080, 929.8429, 930.0592, 972.1794,
     508.0057, {-0.165, 0.0099, -0.00075376, 5.3699e-05, 0.01}, kPi},
    {"pandaset_front_right_camera", kPandaset, K::kOpencvPinhole, 1920, 1080, 930.0407, 930.0324, 965.0525,
     463.4161, {-0.1614, -0.0027, -0.00029662, -0.00028927, 0.0181}, kPi},
    {"pandaset_left_camera", kPandaset, K::kOpencvPinhole, 1920, 1080, 930.4514, 930.0891, 991.6883,
     541.6057, {-0.1582, -0.0266, -0.00015221, 0.00059011, 0.0449}, kPi},
    {"pandaset_right_camera", kPandaset, K::kOpencvPinhole, 1920, 1080, 922.5465, 922.4229, 945.057,
     517.575, {-0.1648, 0.0191, 0.0027, -8.5282e-07, -9.6983e-05}, kPi},
    {"tum_vi_cam0", kTumVi, K::kOpencvFisheye, 512, 512, 190.97847715128717, 190.9733070521226,
     254.93170605935475, 256.8974428996504, {0.0034823894022493434, 0.0007150348452162257,
     -0.0020532361418706202, 0.00020293673591811182}, kPi},
    {"tum_vi_cam1", kTumVi, K::kOpencvFisheye, 512, 512, 190.44236969414825, 190.4344384721956,
     252.59949716835982, 254.91723064636983, {0.0034003170790442797, 0.001766278153469831,
     -0.00266312569781606, 0.0003299517423931039}, kPi},
    {"basalt_euroc_ds_calib_cam0", kBasalt, K::kDoubleSphere, 752, 480, 349.7560023050409,
     348.72454229977035, 365.89440762590147, 249.32995565708703, {-0.2409573942178872, 0.566996899163044},
     kPi},
    {"basalt_euroc_ds_calib_cam1", kBasalt, K::kDoubleSphere, 752, 480, 361.6713883800533,
     360.5856493689301, 379.40818394080867, 255.9772968522045, {-0.21300835384809327, 0.5767008625037023},
     kPi},
    {"basalt_euroc_eucm_calib_cam0", kBasalt, K::kEucm, 752, 480, 460.76484651566466, 459.4051018049483,
     365.8937161309615, 249.33499869752444, {0.5903365915227143, 1.127468196965374}, kPi},
    {"basalt_euroc_eucm_calib_cam1", kBasalt, K::kEucm, 752, 480, 459.55216904505176, 458.17181312352056,
     379.4066773637502, 255.98301446219284, {0.6049889282227827, 1.0907289821146677}, kPi},
    {"basalt_tumvi_512_ds_calib_cam0", kBasalt, K::kDoubleSphere, 512, 512, 158.28600034966976,
     158.2743455478755, 254.96116578191652, 256.8894394501779, {-0.17213086034353242, 0.5931177593944744},
     kPi},
    {"basalt_tumvi_512_ds_calib_cam1", kBasalt, K::kDoubleSphere, 512, 512, 157.91830144176308,
     157.8901286125632, 252.56547609702952, 255.02489416194655, {-0.17114780716007857, 0.5925543396658507},
     kPi},
    {"basalt_tumvi_512_eucm_calib_cam0", kBasalt, K::kEucm, 512, 512, 191.14799836282188,
     191.13150963902817, 254.9585771534443, 256.88154645599445, {0.6291060881178562, 1.0418067381860867},
     kPi},
    {"basalt_tumvi_512_eucm_calib_cam1", kBasalt, K::kEucm, 512, 512, 190.47905769226574,
     190.44567561523215, 252.55882115024332, 255.02104780344698, {0.6281040684983363, 1.041250259119081},
     kPi},
    {"dgp_scene01_CAMERA_01", kDgp, K::kPinhole, 1936, 1216, 2167.6926048451924, 2156.230994942208,
     951.519334127026, 604.9892891421556, {}, kPi},
    {"dgp_scene01_CAMERA_05", kDgp, K::kPinhole, 1936, 1216, 1062.3648601535501, 1056.7635782913833,
     939.4697803032266, 622.4747956076209, {}, kPi},
    {"dgp_scene01_CAMERA_06", kDgp, K::kPinhole, 1936, 1216, 1054.931507576469, 1051.8695839099687,
     943.1532611405323, 597.23698434636, {}, kPi},
    {"dgp_scene02_CAMERA_01", kDgp, K::kPinhole, 1936, 1216, 2181.530254382263, 2181.6034466840038,
     928.0218817103168, 615.9567879463117, {}, kPi},
    {"dgp_scene02_CAMERA_05", kDgp, K::kPinhole, 1936, 1216, 1057.0685006265498, 1055.9745605834144,
     964.6834850172629, 588.6612498587956, {}, kPi},
    {"dgp_scene02_CAMERA_06", kDgp, K::kPinhole, 1936, 1216, 1060.7556963722263, 1059.2549314610033,
     946.5584747928981, 611.407084771089, {}, kPi},
    {"dgp_scene02_CAMERA_07", kDgp, K::kPinhole, 1936, 1216, 1058.949432375444, 1056.7776258435003,
     966.0260232796186, 615.2019014245489, {}, kPi},
    {"dgp_scene02_CAMERA_08", kDgp, K::kPinhole, 1936, 1216, 1057.2909120690622, 1060.1497929739965,
     966.4159674505777, 619.2699631002707, {}, kPi},
    {"dgp_scene02_CAMERA_09", kDgp, K::kPinhole, 1936, 1216, 1063.4579724697585, 1065.2223608725776,
     944.6657652450222, 612.6983955581646, {}, kPi},
    {"gsplat_camera_cross_left_120fov", kGsplat, K::kFtheta, 3840, 2160, 1, 1, 1919.6995849609375,
     1486.5096435546875, {1888.8380126953125, -41.771766662597656, 111.50472259521484, -180.27139282226562,
     64.0710220336914, 0.9996691346168518, 3.400261675778893e-06, 3.7369081837823614e-05},
     1.3461724520632263},
    {"gsplat_camera_cross_right_120fov", kGsplat, K::kFtheta, 3840, 2160, 1, 1, 1903.4903564453125,
     1487.872314453125, {1886.3172607421875, -35.367828369140625, 90.5334701538086, -156.0066375732422,
     54.767032623291016, 0.9997639060020447, 4.3443131289677694e-05, -1.3164923075237311e-05},
     1.3571680263507908},
    {"gsplat_camera_front_tele_30fov", kGsplat, K::kFtheta, 3840, 2160, 1, 1, 1866.1881103515625,
     1087.905517578125, {7368.25439453125, -297.1230773925781, 5390.48388671875, -23865.341796875,
     32739.572265625, 0.9999761581420898, 0.00033564463956281543, -0.00019935681484639645},
     0.3063052837250049},
    {"gsplat_camera_front_wide_120fov", kGsplat, K::kFtheta, 3840, 2160, 1, 1, 1924.16064453125,
     1484.1636962890625, {1889.2742919921875, -41.42326354980469, 108.2840805053711, -175.028564453125,
     61.991058349609375, 0.9997609853744507, 5.547042383113876e-05, 1.6676285667927004e-05},
     1.3461724520632263},
    {"gsplat_camera_rear_left_70fov", kGsplat, K::kFtheta, 3840, 2160, 1, 1, 1926.4249267578125,
     1080.392333984375, {3156.104248046875, -43.0966682434082, 504.6554260253906, -1472.591064453125,
     1275.3272705078125, 0.9998367428779602, 2.931952622020617e-06, 7.690367056056857e-05},
     0.6974335690969341},
    {"gsplat_camera_rear_right_70fov", kGsplat, K::kFtheta, 3840, 2160, 1, 1, 1941.531494140625,
     1055.3516845703125, {3122.915771484375, -41.2835693359375, 505.6195983886719, -1474.0780029296875,
     1270.89453125, 0.9998620748519897, -1.6377008478229982e-06, 0.0001017441027215682},
     0.7115707360380882},
    {"gsplat_camera_front_fisheye_140fov", kGsplat, K::kOpencvFisheye, 3840, 2160, 1913.76478, 1913.99708,
     1928.184506, 1083.862789, {-0.030093122, -0.005103817, -0.000849622, 0.001079542}, 1.2217304763960306},
    {"gsplat_camera_left_fisheye_mild", kGsplat, K::kOpencvFisheye, 640, 480, 200, 200, 320, 240, {0.02,
     0.01, 0.005, 0.002}, 1.8},
    {"gsplat_camera_rear_fisheye_nodist", kGsplat, K::kOpencvFisheye, 1920, 1080, 600, 600, 960, 540, {0, 0,
     0, 0}, kPi / 2},
};
// clang-format on

const Row& row_of(const std::string& name) {
  const auto* const found =
      std::find_if(std::begin(kRows), std::end(kRows), [&](const Row& row) { return name == row.name; });
  if (found == std::end(kRows)) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format("camera: found \"{}\", allowed {}", name, fmt::join(builtin_camera_names(), ", ")));
  }
  return *found;
}

}  // namespace

std::vector<std::string> builtin_camera_names() {
  std::vector<std::string> names;
  for (const Row& row : kRows) names.emplace_back(row.name);
  return names;
}

std::string builtin_camera_source(const std::string& name) { return row_of(name).source.text; }

Camera builtin_camera(const std::string& name) {
  const Row& row = row_of(name);
  Camera camera;
  camera.name = row.name;
  camera.width = row.width;
  camera.height = row.height;
  camera.fx = row.fx;
  camera.fy = row.fy;
  camera.cx = row.cx + 0.5 - row.source.first_pixel_centre;
  camera.cy = row.cy + 0.5 - row.source.first_pixel_centre;
  camera.shutter = row.source.shutter;
  const auto& p = row.parameters;
  if (row.kind == LensKind::kFtheta) {
    set_ftheta(camera, row.kind, {p[0], p[1], p[2], p[3], p[4]}, {p[5], p[6], p[7]}, row.max_angle);
  } else if (row.kind != LensKind::kPinhole) {
    const auto count = static_cast<std::ptrdiff_t>(lens_parameter_names(row.kind).size()) - 1;
    std::vector<double> parameters(p.begin(), p.begin() + count);
    parameters.push_back(row.max_angle);
    camera.lens = Lens(row.kind, parameters, "camera " + camera.name);
  }
  return camera;
}

}  // namespace simuli
