/* What a run of path tracing did and cost, as JSON. The README lists the keys. */
#ifndef HPR_IO_REFERENCE_REPORT_H
#define HPR_IO_REFERENCE_REPORT_H

#include "baseline/reference.h"

typedef struct hpr_reference_picture {
    const char *camera;
    int width, height;
    double noise;           /* RMS standard error of a pixel over RMS radiance, all channels together */
    double *mean_radiance;  /* [channels] over all pixels, W/m2/sr */
    double *standard_error; /* [channels] of that */
} hpr_reference_picture;

typedef struct hpr_reference_report {
    const hpr_reference *reference;
    const char *scene_path;
    int samples;
    size_t picture_count;
    const hpr_reference_picture *picture; /* [picture_count] */
} hpr_reference_report;

/* Errors: HPR_ERR_IO, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. */
hpr_status hpr_reference_report_write(hpr_context *ctx, const hpr_reference_report *report, const char *path);

#endif
