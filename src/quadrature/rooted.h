/* Slender elements in frames that begin where the other side is near. */
#ifndef HPR_QUADRATURE_ROOTED_H
#define HPR_QUADRATURE_ROOTED_H

#include "quadrature/pair.h"

/*
 * An element ten thousand times longer than wide errs, where it ends, by rounding of its length, and its
 * plane there by as much as that turns it: a pair that is measured from the far end knows nothing of the near
 * one. So a slender parallelogram or triangle of degree 0, for which it does not matter where parameters
 * begin, is described from its corner next to the other side on, with a normal that is exact but for its own
 * rounding; others are left as they are.
 */
void hpr_frames_root(hpr_element_frame *recv, hpr_element_frame *send);

#endif
