// Written by brdf-baker 0.1.0. What it says of itself, as JSON strings:
// brdf-baker.texels = "9 5 rg16unorm"
// brdf-baker.channels = "scale,bias"
// brdf-baker.table = "sample"
// brdf-baker.note = "\u03b1\u00b2 = \"width\" \u2192 \u00e9 \u6f22\u5b57 \ud83d\ude42"

#include <stdint.h>

enum { TABLE_RG16UNORM_WIDTH = 9, TABLE_RG16UNORM_HEIGHT = 5, TABLE_RG16UNORM_CHANNELS = 2 };

// 9 x 5 texels of 2 values, each a share of 65535; rows from the top, texels from the left.
const uint16_t TABLE_RG16UNORM[90] = {
    0, 21189, 777, 21966, 1554, 22743, 2331, 23520, 3108, 24297, 3885, 25074, 4662, 25851, 5439,
    26628, 6216, 27405, 2121, 23310, 2898, 24087, 3675, 24864, 4452, 25641, 5229, 26418, 6006,
    27195, 6783, 27972, 7560, 28749, 8337, 29526, 4242, 25431, 5019, 26208, 5796, 26985, 6573,
    27762, 7350, 28539, 8127, 29316, 8904, 30093, 9681, 30870, 10458, 31647, 6363, 27552, 7140,
    28329, 7917, 29106, 8694, 29883, 9471, 30660, 10248, 31437, 11025, 32214, 11802, 32991, 12579,
    33768, 8484, 29673, 9261, 30450, 10038, 31227, 10815, 32004, 11592, 32781, 12369, 33558, 13146,
    34335, 13923, 35112, 14700, 35889,
};
// the end
