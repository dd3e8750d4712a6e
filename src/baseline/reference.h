/* A scene made ready for path tracing, for those who report on it. */
#ifndef HPR_BASELINE_REFERENCE_H
#define HPR_BASELINE_REFERENCE_H

#include "baseline/tracer.h"

#include <hprad/reference.h>

struct hpr_reference {
    hpr_context *context;
    const hpr_scene *scene; /* borrowed */
    hpr_patches *patches;
    hpr_tracer tracer;
    hpr_camera framing; /* if the scene has no camera */
    uint64_t seed;
};

#endif
