#include "measure/truth_frame.h"
#include "base/host.h"
#include <stdlib.h>

/* From inside a wall everything is seen from behind, and nothing is lit. Figures of that would look perfect. */
static int check_outside(const truth_frame *frame) {
  const size_t pixels = (size_t)frame->view.width * frame->view.height;
  for (size_t i = 0; i < pixels; i++)
    if (!frame->view.surfaces[i].behind || frame->visibility[i] > 0.0f)
      return 0;
  return host_fail(HOST_BAD_INPUT, "the camera is inside a wall: it sees every surface from behind, and none is lit");
}

int truth_frame_cast(truth_frame *out, truth_store *store, const host_setup *setup, uint32_t sun_samples) {
  const size_t pixels = (size_t)setup->width * setup->height;
  out->view = (truth_view){.camera = &setup->camera,
                           .width = setup->width,
                           .height = setup->height,
                           .surfaces = host_allocate(pixels, sizeof *out->view.surfaces)};
  out->visibility = host_allocate(pixels, sizeof *out->visibility);
  const truth_asked asked = {.light = &setup->light, .max_depth = setup->shadow_distance, .samples = sun_samples};
  int code = truth_store_view(store, &out->view);
  if (code == 0)
    code = truth_store_visibility(store, &out->view, &asked, out->visibility, &out->convergence);
  return code ? code : check_outside(out);
}

void truth_frame_free(truth_frame *frame) {
  free(frame->view.surfaces);
  free(frame->visibility);
  *frame = (truth_frame){0};
}

metrics_frame truth_frame_against(const truth_frame *truth, const host_setup *setup, const stage_frame *drawn) {
  return (metrics_frame){.view = &truth->view,
                         .light = &setup->light,
                         .shadow_distance = setup->shadow_distance,
                         .visibility = truth->visibility,
                         .mask = drawn->mask,
                         .view_depth = drawn->view_depth};
}
