/* How far a solution is from a better one, at the same points whatever its elements are. */
#ifndef HPR_APP_STUDY_ERROR_H
#define HPR_APP_STUDY_ERROR_H

#include "solver/solution.h"

#include <hprad/study.h>

typedef struct hpr_yardstick {
    hpr_context *context;
    const hpr_solution *truth;          /* borrowed */
    size_t count;                       /* of the points of the integrals; those of a patch are consecutive */
    uint32_t *patch;                    /* [count] */
    double *place;                      /* [count][2] parameters of the patch */
    double *weight;                     /* [count] m2; their sum is the area */
    double *value;                      /* [count][channels] H* */
    size_t probe_count;                 /* of the points that were given */
    const double *probe, *probe_normal; /* [probe_count][3] borrowed */
    double *probe_value;                /* [probe_count][channels]; NaN: on no patch */
} hpr_yardstick;

/* Where to measure. */
typedef struct hpr_yardstick_points {
    int subdivide; /* the points are Gauss points on the truth's elements, cut to so many subdivisions of each
                      patch where they are coarser; */
    int per_edge;  /* so many per edge of such a cell */
    size_t probe_count;
    const double *probe, *probe_normal; /* [probe_count][3] */
    const double *known; /* [probe_count][channels] irradiance there; NULL: that of the truth */
} hpr_yardstick_points;

/* The points on the patches of the truth, and its values there. Borrows `truth` and the probe points. Errors:
 * HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_UNSUPPORTED. Fini accepts a zeroed struct. */
hpr_status hpr_yardstick_init(const hpr_solution *truth, const hpr_yardstick_points *points,
                              hpr_yardstick *yardstick);
void hpr_yardstick_fini(hpr_yardstick *yardstick);

/* Fills the six errors of `row` as hpr_study_row defines them; those at points are NaN without points.
 * `solution` has the patches and channels of the truth (else HPR_ERR_FORMAT). Errors: also as above. */
hpr_status hpr_yardstick_measure(const hpr_yardstick *yardstick, const hpr_solution *solution,
                                 hpr_study_row *row);

#endif
