/* Where something stands on a patch: the segments in which other patches meet its plane. */
#ifndef HPR_LINK_FEET_H
#define HPR_LINK_FEET_H

#include "patch/patches.h"

/* A segment in the patch's parameters. */
typedef struct hpr_foot {
    double from[2], to[2];
} hpr_foot;

typedef struct hpr_foot_box hpr_foot_box;

/* The feet on one patch after the other. */
typedef struct hpr_feet {
    const hpr_patches *patches; /* borrowed */
    double slack;               /* metres */
    uint32_t patch;             /* the one that was asked for last; its feet, those that cut it: */
    hpr_foot *foot;
    size_t count, capacity;
    bool faced;        /* some patch lies against it */
    hpr_foot_box *box; /* [patches->count] rising by the lower end along x */
    double widest;     /* along x */
} hpr_feet;

/* slack_m: what is nearer to a plane lies in it. Fini it in any case. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_feet_init(const hpr_patches *patches, double slack_m, hpr_feet *feet);
void hpr_feet_fini(hpr_feet *feet);

/* Finds those on a patch. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_feet_find(hpr_feet *feet, uint32_t patch);

/* Does a segment run through the inside of a parameter domain, by more than `slack` parameters? opposite: of
 * a quadrilateral. */
bool hpr_foot_cuts(const hpr_foot *foot, hpr_shape shape, const double opposite[2], double slack);

#endif
