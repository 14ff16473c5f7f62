/* filters.c: filters on moments, soft ones, and those that send rays. */
#include "hard/hard.h"

/* clang-format off */
const hard_filter hard_filters[HARD_ALL_FILTERS] = {
    {"vsm", CSM_FILTER_VSM, CSM_MOMENTS_FLOAT32, 2, 1, CSM_SAMPLING_BILINEAR},
    {"evsm4", CSM_FILTER_EVSM4, CSM_MOMENTS_FLOAT32, 1, 6, CSM_SAMPLING_ANISOTROPIC},
    {"msm4", CSM_FILTER_MSM4, CSM_MOMENTS_FLOAT32, 0, 4, CSM_SAMPLING_TRILINEAR},
    {"evsm4 float16", CSM_FILTER_EVSM4, CSM_MOMENTS_FLOAT16, 2, 1, CSM_SAMPLING_BILINEAR},
    {"pcss", CSM_FILTER_PCSS, 0, 0, 1, 0},
    {"vssm", CSM_FILTER_VSSM, CSM_MOMENTS_FLOAT32, 0, 6, CSM_SAMPLING_TRILINEAR},
    {"backprojection", CSM_FILTER_BACKPROJECTION, 0, 0, 1, 0},
    {"exact", CSM_FILTER_EXACT, 0, 0, 1, 0},
    {"exact_soft", CSM_FILTER_EXACT_SOFT, 0, 0, 1, 0},
};
/* clang-format on */

void hard_filter_set(csm_config *config, const hard_filter *filter) {
  config->filter = filter->filter;
  config->moment_format = filter->format;
  config->moment_blur_texels = filter->blur_texels;
  config->moment_levels = filter->levels;
  config->moment_sampling = filter->sampling;
}
