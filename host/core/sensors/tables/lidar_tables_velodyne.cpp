// Beam tables of Velodyne LiDARs: angles in microradians, lever arms in 0.1 mm, times in ns, top beam first.
// The end of the file names sources and licences.
#include "host/core/sensors/tables/lidar_tables.hpp"

namespace simuli {
namespace {

// clang-format off
constexpr std::int32_t kVelodyneHdl32eElevation[] = {
    186227, 162839, 139626, 116413, 93026, 69813, 46600, 23213, 0, -23213, -46600, -69813, -93026, -116413,
    -139626, -162839, -186227, -209440, -232652, -256040, -279253, -302466, -325853, -349066, -372279,
    -395666, -418879, -442092, -465479, -488692, -511905, -535292};
constexpr LidarMode kVelodyneHdl32eModes[] = {{10.0, 2170}, {5.0, 4340}, {20.0, 1085}};
constexpr std::int32_t kVelodyneHdl64eS2SztakiElevation[] = {
    86744, 78420, 69882, 61130, 51961, 43395, 34414, 25224, 17051, 8876, -3798, -9930, -20148, -27707, -35876,
    -45263, -55662, -64827, -72761, -82108, -90630, -98936, -109248, -119739, -126785, -135826, -145846,
    -153041, -158331, -163009, -167884, -171357, -174434, -180867, -183934, -189556, -191038, -201067,
    -210665, -216717, -226444, -234001, -245766, -254784, -264903, -273830, -281204, -288922, -298660,
    -310010, -317961, -326788, -334833, -341564, -351149, -364064, -371894, -381967, -390212, -396664,
    -404637, -416323, -426197, -433628};
constexpr std::int32_t kVelodyneHdl64eS2SztakiAzimuthOffset[] = {
    43893, -12062, -68148, -125053, 137808, 82402, 25535, -33069, -89044, -145317, 158679, 100294, 45966,
    -13006, -67165, -125581, 138677, 80445, 24313, -32373, -88929, -145789, 159964, 100659, 45795, -11200,
    -69245, -124894, 44893, 138626, -11752, 83133, -68531, 23408, -127419, -31646, 140065, 82927, 24858,
    -34041, -89736, -149732, 163117, 104820, 47471, -12004, -70093, -129985, 143746, 83850, 25334, -33781,
    -92789, -153371, 167929, 107632, 48322, -12004, -72412, -133100, 150240, 86116, 26883, -35831};
constexpr std::int32_t kVelodyneHdl64eS2SztakiVerticalOffset[] = {
    2128, 2122, 2116, 2110, 2103, 2097, 2090, 2084, 2078, 2072, 2063, 2059, 2051, 2046, 2040, 2033, 2026,
    2019, 2013, 2007, 2000, 1994, 1987, 1979, 1974, 1967, 1960, 1955, 1242, 1947, 1236, 1941, 1232, 1934,
    1226, 1928, 1221, 1215, 1209, 1205, 1198, 1193, 1186, 1180, 1173, 1167, 1162, 1157, 1150, 1142, 1137,
    1131, 1125, 1121, 1114, 1105, 1099, 1092, 1086, 1081, 1075, 1067, 1059, 1054};
constexpr std::int32_t kVelodyneHdl64eS2SztakiHorizontalOffset[] = {
    -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260,
    260, -260, 260, -260, 260, -260, 260, -260, 260, -260, -260, 260, 260, -260, -260, 260, 260, -260, 260,
    -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260, 260, -260,
    260, -260, 260, -260, 260, -260, 260};
constexpr LidarMode kVelodyneHdl64eS2SztakiModes[] = {{10.0, 2083}, {5.0, 4167}, {15.0, 1389}};
constexpr std::int32_t kVelodyneHdl64eS3XiescElevation[] = {
    34210, 27267, 22568, 15620, 10307, 3561, -1549, -7886, -13200, -19944, -25460, -31588, -36488, -43427,
    -48731, -54439, -60551, -66659, -72558, -79062, -83935, -89616, -95696, -102780, -108036, -114497,
    -119537, -126182, -131811, -138635, -143444, -149445, -153144, -162315, -170069, -177605, -187686,
    -197139, -207927, -214571, -223919, -229741, -240953, -249417, -260519, -268517, -277615, -284032,
    -293236, -303135, -313528, -321645, -330268, -335927, -347179, -356546, -367629, -375084, -383550,
    -390212, -400830, -411010, -421441, -428567};
constexpr std::int32_t kVelodyneHdl64eS3XiescAzimuthOffset[] = {
    36814, -1914, -37910, -76589, 99195, 60054, 23284, -15542, -51308, -90473, 111433, 72644, 37479, -1864,
    -37048, -75748, 97970, 59426, 23920, -15195, -50730, -89596, 113179, 73544, 38244, -954, -39321, -76482,
    99061, 59542, 24256, -15297, 50601, -5967, -64320, -121009, 145480, 88543, 29048, -27437, -85248, -144862,
    168767, 109553, 52428, -6800, -64134, -124136, 148715, 90373, 31843, -28384, -87073, -148726, 173550,
    114117, 54276, -5072, -66529, -127863, 155383, 95648, 31723, -28144};
constexpr std::int32_t kVelodyneHdl64eS3XiescVerticalOffset[] = {
    2041, 2046, 2050, 2054, 2058, 2063, 2067, 2071, 2075, 2080, 2084, 2088, 2092, 2097, 2101, 2105, 2109,
    2114, 2118, 2123, 2126, 2130, 2135, 2140, 2144, 2148, 2152, 2157, 2161, 2166, 2170, 2174, 1437, 1443,
    1448, 1453, 1460, 1466, 1473, 1477, 1483, 1487, 1494, 1500, 1507, 1512, 1519, 1523, 1529, 1536, 1543,
    1549, 1555, 1558, 1566, 1573, 1581, 1586, 1592, 1597, 1605, 1612, 1620, 1625};
constexpr auto kVelodyneHdl64eS3XiescHorizontalOffset = repeated<64>(std::array{-260, 260});
constexpr LidarMode kVelodyneHdl64eS3XiescModes[] = {{10.0, 1736}, {5.0, 3472}, {20.0, 868}};
constexpr std::int32_t kVelodyneHdl64eUtexasElevation[] = {
    35270, 29320, 23372, 17428, 11486, 5547, -390, -6325, -12259, -18190, -24121, -30050, -35978, -41906,
    -47833, -53760, -59687, -65613, -71540, -77468, -83396, -89326, -95256, -101188, -107121, -113056,
    -118993, -124933, -130874, -136819, -142766, -148716, -156202, -165172, -174132, -183082, -192023,
    -200956, -209881, -218800, -227713, -236620, -245523, -254421, -263317, -272210, -281102, -289992,
    -298882, -307772, -316664, -323895, -334453, -343352, -352254, -361162, -370074, -378993, -387918,
    -396851, -405792, -414742, -423702, -431289};
constexpr std::int32_t kVelodyneHdl64eUtexasAzimuthOffset[] = {
    34907, 10472, -34907, -61087, 104720, 69813, 29671, -4363, -47124, -78540, 109083, 85521, 39270, 8727,
    -34907, -68068, 104720, 69813, 30543, 0, -47997, -83776, 113446, 82030, 39270, 13963, -39270, -69813,
    104720, 69813, 22689, 0, 43633, 0, -61087, -104720, 148353, 95993, 31416, -17453, -78540, -139626, 165806,
    122173, 55851, 0, -56723, -113446, 157080, 104720, 34907, -17453, -87266, -139626, 174533, 122173, 61087,
    -8727, -61087, -122173, 165806, 104720, 34907, -17453};
constexpr auto kVelodyneVlp16Elevation = in_steps_deg<16>(15.0, 2.0);
constexpr std::int32_t kVelodyneVlp16TimeOffset[] = {
    34560, 29952, 25344, 20736, 16128, 11520, 6912, 2304, 32256, 27648, 23040, 18432, 13824, 9216, 4608, 0};
constexpr LidarMode kVelodyneVlp16Modes[] = {{10.0, 1808}, {5.0, 3617}, {20.0, 904}};
constexpr auto kVelodyneVlp16HiresElevation = in_steps_deg<16>(10.0, 4.0 / 3.0);
constexpr std::int32_t kVelodyneVlp32cElevation[] = {
    261799, 180345, 122173, 81455, 58172, 40719, 29095, 23265, 17453, 11641, 5812, 0, -5812, -11641, -17453,
    -23265, -29095, -34907, -40719, -46548, -52360, -58172, -64001, -69813, -81455, -93078, -107303, -126606,
    -154339, -197397, -272952, -436332};
constexpr std::int32_t kVelodyneVlp32cAzimuthOffset[] = {
    24435, -24435, 24435, -24435, 24435, -24435, 73304, 24435, -24435, -73304, 73304, 24435, -24435, -73304,
    73304, 24435, -24435, -73304, 73304, 24435, -24435, -73304, 73304, 24435, -24435, -73304, 24435, -24435,
    24435, -24435, 24435, -24435};
constexpr std::int32_t kVelodyneVls128Elevation[] = {
    261799, 205076, 169297, 147131, 132296, 121824, 113097, 106116, 100007, 94771, 90408, 86917, 84299, 82380,
    80460, 78540, 76620, 74700, 72780, 70860, 68941, 67021, 65101, 63181, 61261, 59341, 57421, 55501, 53582,
    51662, 49742, 47822, 45902, 43982, 42062, 40143, 38223, 36303, 34383, 32463, 30543, 28623, 26704, 24784,
    22864, 20944, 19024, 17104, 15184, 13265, 11345, 9425, 7505, 5585, 3665, 1745, -175, -2094, -4014, -5934,
    -7854, -9774, -11694, -13614, -15533, -17453, -19373, -21293, -23213, -25133, -27053, -28972, -30892,
    -32812, -34732, -36652, -38572, -40492, -42412, -44331, -46251, -48171, -50091, -52011, -53931, -55851,
    -57770, -59690, -61610, -63530, -65450, -67370, -69290, -71209, -73129, -75049, -76969, -78889, -80809,
    -82729, -84648, -86568, -88488, -90408, -92328, -94248, -96168, -98088, -100007, -101927, -103847,
    -105767, -107687, -109607, -111527, -113446, -116064, -119555, -124791, -133518, -145770, -161338,
    -180572, -204937, -236754, -279986, -341770, -436332};
constexpr auto kVelodyneVls128AzimuthOffset = repeated<128>(
    std::array{-15900, -47682, -79378, -110898, 110898, 79378, 47682, 15900});
constexpr std::int32_t kVelodyneVls128TimeOffset[] = {
    18655, 26650, 13325, 42640, 7995, 37310, 2665, 31980, 15990, 23985, 10660, 39975, 5330, 34645, 0, 29315,
    37310, 2665, 31980, 18655, 26650, 13325, 42640, 7995, 34645, 0, 29315, 15990, 23985, 10660, 39975, 5330,
    13325, 42640, 7995, 37310, 2665, 31980, 18655, 26650, 10660, 39975, 5330, 34645, 0, 29315, 15990, 23985,
    31980, 18655, 26650, 13325, 42640, 7995, 37310, 2665, 29315, 15990, 23985, 10660, 39975, 5330, 34645, 0,
    7995, 37310, 2665, 31980, 18655, 26650, 13325, 42640, 5330, 34645, 0, 29315, 15990, 23985, 10660, 39975,
    26650, 13325, 42640, 7995, 37310, 2665, 31980, 18655, 23985, 10660, 39975, 5330, 34645, 0, 29315, 15990,
    2665, 31980, 18655, 26650, 13325, 42640, 7995, 37310, 0, 29315, 15990, 23985, 10660, 39975, 5330, 34645,
    42640, 7995, 37310, 2665, 31980, 18655, 26650, 13325, 39975, 5330, 34645, 0, 29315, 15990, 23985, 10660};
constexpr LidarMode kVelodyneVls128Modes[] = {{10.0, 1876}, {5.0, 3752}, {20.0, 938}};
constexpr LidarMode kNuscenesLidarTopHdl32eModes[] = {{20.0, 1084}};

constexpr LidarTable kVelodyneTables[] = {
    {.name = "velodyne_hdl32e", .elevation_urad = kVelodyneHdl32eElevation, .modes = kVelodyneHdl32eModes,
     .range_min_m = 0.05, .range_max_m = 100.0, .divergence_horizontal_urad = 3333,
     .divergence_vertical_urad = 1667,
     .source = "ros-drivers/velodyne: velodyne_pointcloud/params/32db.yaml",
     .licence = "BSD-3-Clause",
     .note = "46.08 us firing cycle; usable returns from 1 m on; divergence 4 x 2 inch at 100 ft"},
    {.name = "velodyne_hdl64e_s2_sztaki", .elevation_urad = kVelodyneHdl64eS2SztakiElevation,
     .azimuth_offset_urad = kVelodyneHdl64eS2SztakiAzimuthOffset,
     .vertical_offset_100um = kVelodyneHdl64eS2SztakiVerticalOffset,
     .horizontal_offset_100um = kVelodyneHdl64eS2SztakiHorizontalOffset,
     .modes = kVelodyneHdl64eS2SztakiModes, .range_min_m = 0.9, .range_max_m = 120.0,
     .source = "ros-drivers/velodyne: velodyne_pointcloud/params/64e_s2.1-sztaki.yaml",
     .licence = "BSD-3-Clause",
     .note = "one unit's calibration, 48 us firing cycle"},
    {.name = "velodyne_hdl64e_s3_xiesc", .elevation_urad = kVelodyneHdl64eS3XiescElevation,
     .azimuth_offset_urad = kVelodyneHdl64eS3XiescAzimuthOffset,
     .vertical_offset_100um = kVelodyneHdl64eS3XiescVerticalOffset,
     .horizontal_offset_100um = kVelodyneHdl64eS3XiescHorizontalOffset, .modes = kVelodyneHdl64eS3XiescModes,
     .range_min_m = 0.9, .range_max_m = 120.0,
     .source = "ros-drivers/velodyne: velodyne_pointcloud/params/64e_s3-xiesc.yaml",
     .licence = "BSD-3-Clause",
     .note = "one unit's calibration, 57.6 us firing cycle"},
    {.name = "velodyne_hdl64e_utexas", .elevation_urad = kVelodyneHdl64eUtexasElevation,
     .azimuth_offset_urad = kVelodyneHdl64eUtexasAzimuthOffset, .modes = kVelodyneHdl64eS2SztakiModes,
     .range_min_m = 0.9, .range_max_m = 120.0,
     .source = "ros-drivers/velodyne: velodyne_pointcloud/params/64e_utexas.yaml",
     .licence = "BSD-3-Clause",
     .note = "one unit's calibration without lever arms, 48 us firing cycle"},
    {.name = "velodyne_vlp16", .elevation_urad = kVelodyneVlp16Elevation,
     .time_offset_ns = kVelodyneVlp16TimeOffset, .modes = kVelodyneVlp16Modes, .range_min_m = 0.5,
     .range_max_m = 100.0, .divergence_horizontal_urad = 3000, .divergence_vertical_urad = 1500,
     .source = "ros-drivers/velodyne: velodyne_pointcloud/params/VLP16db.yaml",
     .licence = "BSD-3-Clause",
     .note = "55.296 us firing cycle, beams 2.304 us apart; divergence as commonly simulated"},
    {.name = "velodyne_vlp16_hires", .elevation_urad = kVelodyneVlp16HiresElevation,
     .modes = kVelodyneVlp16Modes, .range_min_m = 0.5, .range_max_m = 100.0,
     .source = "ros-drivers/velodyne: velodyne_pointcloud/params/VLP16_hires_db.yaml",
     .licence = "BSD-3-Clause",
     .note = "55.296 us firing cycle; the source has no firing order"},
    {.name = "velodyne_vlp32c", .elevation_urad = kVelodyneVlp32cElevation,
     .azimuth_offset_urad = kVelodyneVlp32cAzimuthOffset, .modes = kVelodyneVlp16Modes, .range_min_m = 0.5,
     .range_max_m = 200.0, .divergence_horizontal_urad = 3000, .divergence_vertical_urad = 1500,
     .source = "ros-drivers/velodyne: velodyne_pointcloud/params/VeloView-VLP-32C.yaml",
     .licence = "BSD-3-Clause",
     .note = "55.296 us firing cycle; divergence as commonly simulated; the source has no firing order"},
    {.name = "velodyne_vls128", .elevation_urad = kVelodyneVls128Elevation,
     .azimuth_offset_urad = kVelodyneVls128AzimuthOffset, .time_offset_ns = kVelodyneVls128TimeOffset,
     .modes = kVelodyneVls128Modes, .range_min_m = 0.5, .range_max_m = 245.0,
     .divergence_horizontal_urad = 3000, .divergence_vertical_urad = 1500,
     .source = "ros-drivers/velodyne: velodyne_pointcloud/params/VLS128.yaml",
     .licence = "BSD-3-Clause",
     .note = "53.3 us firing cycle, eight beams every 2.665 us; divergence of the manual (table F-1)"},
    {.name = "nuscenes_lidar_top_hdl32e", .elevation_urad = kVelodyneHdl32eElevation,
     .modes = kNuscenesLidarTopHdl32eModes, .range_min_m = 1.0, .range_max_m = 70.0,
     .divergence_horizontal_urad = 3333, .divergence_vertical_urad = 1667,
     .source = "ros-drivers/velodyne: velodyne_pointcloud/params/32db.yaml",
     .licence = "BSD-3-Clause",
     .note = "HDL-32E at 20 Hz; x forward here, where the dataset has y forward"},
};
// clang-format on

}  // namespace

std::span<const LidarTable> velodyne_lidar_tables() { return kVelodyneTables; }

}  // namespace simuli
