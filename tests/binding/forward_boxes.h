/* forward_boxes.h: how many boxes cast, which forward shaders that trace by themselves look at one by one. */
#define FORWARD_BOXES 40
