/* Pairs in planes that nearly agree, in coordinates that keep the digits of the heights. */
#ifndef HPR_QUADRATURE_FLAT_H
#define HPR_QUADRATURE_FLAT_H

#include "quadrature/pair.h"

/*
 * Turns a pair of which one hardly rises over the plane of the other, the base, so that that plane is z = 0;
 * the base is the receiver, or a sender that is more slender. Others are left as they are, and so are those
 * that count as coplanar, `contact` being how near points touch. Corners that lie in the plane but for
 * rounding are put into it. To be called before blockers or parts are set.
 */
void hpr_pair_flatten(hpr_pair *pair, double contact);

#endif
