// Beam tables of data sets' LiDARs: angles in microradians, lever arms in 0.1 mm, times in ns, top beam first.
// The end of the file names sources and licences.
#include "host/core/sensors/tables/lidar_tables.hpp"

namespace simuli {
namespace {

// clang-format off
constexpr std::int32_t kNcoreGeneric128Elevation[] = {
    252200, 236475, 227504, 220505, 211516, 204291, 195267, 187867, 179018, 171391, 162525, 154654, 145822,
    137829, 128980, 120637, 112155, 103515, 95138, 86499, 77999, 69237, 60406, 51993, 43075, 34558, 32550,
    30316, 27995, 25779, 23562, 21241, 19059, 17157, 14923, 12723, 10542, 7994, 6074, 3700, 1641, -367, -2775,
    -4887, -7173, -9739, -11676, -14137, -16197, -18029, -20385, -22619, -24888, -27157, -29461, -31730,
    -33667, -35797, -38310, -40265, -42673, -45029, -46932, -49340, -51452, -53582, -55868, -57980, -60266,
    -62710, -64595, -67160, -69063, -71227, -73740, -75887, -78156, -80547, -82537, -84875, -86708, -88942,
    -91560, -93619, -95906, -98332, -100304, -102590, -104632, -106727, -116012, -124425, -133622, -142052,
    -151390, -160134, -168930, -177657, -186436, -195320, -203994, -212721, -221482, -230209, -238744,
    -247366, -256092, -264644, -273196, -281679, -290178, -298486, -307195, -315241, -323619, -332066,
    -340339, -348699, -356571, -365105, -372820, -381267, -388772, -397167, -404759, -413137, -420205,
    -435652};
constexpr std::int32_t kNcoreGeneric128AzimuthOffset[] = {
    0, 174, 37856, -35, 38083, 244, 38066, 17, 38031, 244, 38101, 35, 38135, 122, 38066, 77301, 38048, 77161,
    115768, 77266, 115628, 77178, 115768, 76899, 115593, 76917, -77370, -38816, -262, 115593, 38031, 153816,
    192213, 76917, -77667, -38991, -332, 115733, 38083, 153868, 192143, 76952, -78016, -38956, -558, 115698,
    38031, 153973, 192353, 76934, -78156, -39322, -558, 115541, 38031, 154165, 192335, 76934, -78243, -39462,
    -768, 115698, 37926, 154200, 192492, 76986, -78715, -39706, -977, 115680, 37874, 154147, 192492, 76847,
    -78907, -39968, -1100, 115733, 37908, 154322, 192737, 76969, -79203, -40195, -1135, 115768, 37786, 154514,
    193033, 76899, 115802, 76917, 115855, 76829, 115925, -1780, 116082, -1885, 37298, -2164, 37053, -2391,
    37053, -2356, 36809, -2740, 36948, -2845, 36757, -3002, 36495, 76690, 36390, 76515, 116483, 76567, 116483,
    76550, 116501, 76393, 116588, 76550, 116536, 76271, 116588, 76463, 116571, 116588};
constexpr LidarMode kNcoreGeneric128Modes[] = {{10.0, 3600}};
constexpr auto kNcoreHesaiAt128Elevation = in_steps_deg<128>(12.93, 0.2);
constexpr std::int32_t kNcoreHesaiAt128AzimuthOffset[] = {
    0, 18, 38554, -17, 38310, 18, 38345, 0, 38380, -209, 38450, -105, 38450, 140, 38502, 76760, 38537, 76882,
    115820, 76882, 115698, 76917, 115698, 76795, 115698, 77004, -77650, -39601, -35, 115785, 38799, 153764,
    192021, 77004, -77859, -39444, -279, 115698, 38677, 153799, 192266, 77109, -77929, -39479, -279, 115471,
    38624, 153886, 192370, 77126, -78156, -39706, -366, 115541, 38537, 153851, 192545, 77056, -78330, -40020,
    -541, 115506, 38432, 154043, 192789, 77196, -78505, -40142, -576, 115628, 38519, 154113, 192929, 77161,
    -78767, -40195, -628, 115803, 38415, 154340, 193051, 77283, -78994, -40387, -872, 115803, 38432, 154584,
    193383, 77266, 115803, 77301, 115942, 77353, 115907, -1606, 116065, -1815, 38136, -2042, 37926, -2164,
    37856, -2373, 37612, -2531, 37507, -2618, 37333, -2915, 37193, 77074, 37210, 76847, 116641, 76760, 116641,
    76795, 116641, 76672, 116710, 76638, 116832, 76585, 116937, 76393, 116780, 117042};
constexpr LidarMode kNcoreHesaiAt128Modes[] = {{10.0, 1200}};
constexpr std::int32_t kNcorePandasetPandar64Elevation[] = {
    259530, 192335, 140447, 88052, 52849, 35186, 32254, 29252, 26354, 23370, 20455, 17471, 14556, 11572, 8657,
    5672, 2740, -209, -3159, -6091, -9076, -11990, -14957, -17890, -20874, -23789, -26773, -29671, -32673,
    -35605, -38572, -41486, -44471, -47333, -50353, -53267, -56235, -59114, -62134, -64996, -67998, -70895,
    -73880, -76742, -79762, -82589, -85591, -88471, -91473, -94300, -97337, -100147, -103149, -105994,
    -123482, -140866, -158336, -172735, -192754, -209754, -226648, -243334, -329885, -434744};
constexpr std::int32_t kNcorePandasetPandar64AzimuthOffset[] = {
    18186, 18186, 18186, 18186, 18186, 18186, -18186, -54542, -90897, 90897, 54542, 18186, -18186, -54542,
    -90897, 90897, 54542, 18186, -18186, -54542, -90897, 90897, 54542, 18186, -18186, -54542, -90897, 90897,
    54542, 18186, -18186, -54542, -90897, 90897, 54542, 18186, -18186, -54542, -90897, 90897, 54542, 18186,
    -18186, -54542, -90897, 90897, 54542, 18186, -18186, -54542, -90897, 90897, 54542, 18186, 18186, 18186,
    18186, 18186, 18186, 18186, 18186, 18186, 18186, 18186};
constexpr LidarMode kNcorePandasetPandar64Modes[] = {{10.0, 1800}};
constexpr std::int32_t kNcoreWaymoTopElevation[] = {
    38489, 35696, 32302, 29402, 26569, 23787, 20881, 18026, 14595, 11978, 8987, 6172, 3292, 551, -2680, -5451,
    -8486, -11124, -14183, -16813, -20152, -22940, -25897, -28938, -32213, -35538, -39615, -43351, -47440,
    -51703, -56048, -60583, -66177, -70745, -76338, -81595, -87195, -92747, -99254, -105614, -112031, -118298,
    -125329, -132073, -139382, -146820, -154264, -161767, -169730, -177548, -186007, -194275, -202866,
    -211374, -220911, -229849, -239327, -248575, -258088, -267542, -277882, -288184, -298765, -309257};
constexpr LidarMode kNcoreWaymoTopModes[] = {{10.0, 2650}};

constexpr LidarTable kDatasetsTables[] = {
    {.name = "ncore_generic128", .elevation_urad = kNcoreGeneric128Elevation,
     .azimuth_offset_urad = kNcoreGeneric128AzimuthOffset, .modes = kNcoreGeneric128Modes,
     .azimuth_first_urad = 3088220, .range_min_m = 0.3, .range_max_m = 200.0,
     .source = "NVIDIA/ncore: ncore/impl/sensors/test_data/row-offset-spinning-lidar-model-parameters.json",
     .licence = "Apache-2.0",
     .note = "128-beam roof sensor; columns made even, the source's are within 0.15 of a step"},
    {.name = "ncore_hesai_at128", .elevation_urad = kNcoreHesaiAt128Elevation,
     .azimuth_offset_urad = kNcoreHesaiAt128AzimuthOffset, .modes = kNcoreHesaiAt128Modes,
     .azimuth_first_urad = 1047198, .azimuth_span_urad = 2096142, .range_min_m = 1.0, .range_max_m = 200.0,
     .source = "NVIDIA/ncore: "
               "ncore/impl/sensors/test_data/row-offset-spinning-lidar-model-parameters-hesai-at128.json",
     .licence = "Apache-2.0",
     .note = "120 deg field of view in 1200 columns, separable table"},
    {.name = "ncore_pandaset_pandar64", .elevation_urad = kNcorePandasetPandar64Elevation,
     .azimuth_offset_urad = kNcorePandasetPandar64AzimuthOffset, .modes = kNcorePandasetPandar64Modes,
     .azimuth_first_urad = 3140720, .range_min_m = 0.3, .range_max_m = 200.0,
     .divergence_horizontal_urad = 3000, .divergence_vertical_urad = 1500,
     .source = "NVIDIA/ncore: "
               "ncore/impl/sensors/test_data/row-offset-spinning-lidar-model-parameters-pandaset.json",
     .licence = "Apache-2.0",
     .note = "one unit's calibration; divergence as commonly simulated"},
    {.name = "ncore_waymo_top", .elevation_urad = kNcoreWaymoTopElevation, .modes = kNcoreWaymoTopModes,
     .azimuth_first_urad = 557836, .range_min_m = 1.5, .range_max_m = 75.0,
     .divergence_horizontal_urad = 2400, .divergence_vertical_urad = 1500,
     .source = "NVIDIA/ncore: "
               "ncore/impl/sensors/test_data/row-offset-spinning-lidar-model-parameters-waymo.json",
     .licence = "Apache-2.0",
     .note = "top sensor of one segment; range as released; divergence as commonly simulated"},
    {.name = "gsplat_generic128", .elevation_urad = kNcoreGeneric128Elevation,
     .azimuth_offset_urad = kNcoreGeneric128AzimuthOffset, .modes = kNcoreGeneric128Modes,
     .azimuth_first_urad = 3088220, .range_min_m = 0.3, .range_max_m = 200.0,
     .source = "nerfstudio-project/gsplat: "
               "tests/sensors/test_data/row-offset-spinning-lidar-model-parameters.json",
     .licence = "Apache-2.0",
     .note = "128-beam roof sensor; columns made even, the source's are within 0.15 of a step"},
    {.name = "gsplat_waymo", .elevation_urad = kNcoreWaymoTopElevation, .modes = kNcoreWaymoTopModes,
     .azimuth_first_urad = 557836, .range_min_m = 1.5, .range_max_m = 75.0,
     .divergence_horizontal_urad = 2400, .divergence_vertical_urad = 1500,
     .source = "nerfstudio-project/gsplat: "
               "tests/sensors/test_data/row-offset-spinning-lidar-model-parameters-waymo.json",
     .licence = "Apache-2.0",
     .note = "top sensor of one segment; range as released; divergence as commonly simulated"},
};
// clang-format on

}  // namespace

std::span<const LidarTable> datasets_lidar_tables() { return kDatasetsTables; }

}  // namespace simuli
