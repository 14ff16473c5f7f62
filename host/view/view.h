/* view/view.h: csm-host view. */
#ifndef HOST_VIEW_H
#define HOST_VIEW_H

#include "setup/options.h"

/*
 * A window with a camera that flies through the scene. Keys swap the backend and change the settings while it runs.
 * With --frames it runs by itself: keys come from --keys, one a frame, and the last frame is saved as view.png in
 * --out. Returns the exit code: 1 if a swap changed the mask.
 */
int view_command(const host_options *options);

#endif
