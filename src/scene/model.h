/*
 * A model for view factors: named polygons, of which some radiate, some only obstruct, and some change the
 * one that they lie in. Made by a reader (add, then check), afterwards only read. Vertices are taken exactly.
 */
#ifndef HPR_SCENE_MODEL_H
#define HPR_SCENE_MODEL_H

#include "base/context.h"

#include <hprad/scene.h>

typedef enum hpr_surface_kind {
    HPR_SURFACE_RADIATES,  /* has a row */
    HPR_SURFACE_OBSTRUCTS, /* is only in the way */
    HPR_SURFACE_MASKS,     /* lies on its base, face to face: sees nothing else, and hides that part of it */
    HPR_SURFACE_IS_ABSENT  /* a hole in its base */
} hpr_surface_kind;

typedef struct hpr_surface {
    hpr_surface_kind kind;
    size_t corner_count; /* 3 or 4 */
    double corner[4][3]; /* metres, counter-clockwise from the front */
    uint32_t base;       /* the surface that it lies in, or HPR_NONE; less than its own index */
    uint32_t combine;    /* the surface in whose row it counts, or HPR_NONE; less than its own index */
    double emissivity;   /* 0 to 1 */
    char *name;          /* "" if none; owned by the model */
    size_t line;         /* of the file, for messages */
    double normal[3];    /* set by check; zero if there is no area */
    double area_m2;      /* set by check: of the polygon, without regard to others */
} hpr_surface;

typedef struct hpr_model {
    hpr_context *context;
    char *path, *title;
    size_t count, capacity;
    hpr_surface *surface;
    double tolerance; /* as the file asks for it, 0: it does not */
    bool closed;      /* the file says that every row sums to 1 */
    bool exchange;    /* the file asks for script-F instead of F */
} hpr_model;

hpr_status hpr_model_create(hpr_context *ctx, const char *path, hpr_model **model);
void hpr_model_destroy(hpr_model **model);

/* Copies the surface and its name. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_model_add(hpr_model *model, const hpr_surface *surface);

/*
 * Sets normals and areas. Errors: HPR_ERR_FORMAT, naming file, line and surface, if
 *   - a quadrilateral is not planar (a corner farther than 1e-6 of its longest side or diagonal from the mean
 *     plane; less is what rounded coordinates make) or not convex (by more than 1e-9 of a right angle);
 *   - a base has no area, is a mask or a hole, or does not contain the surface within 1e-6 of its size, or
 * the surface faces the wrong way: as the base does if it radiates, against it if it masks;
 *   - a mask or a hole has no base;
 *   - a surface counts in the row of one that has none of its own, or has no row to give.
 * Surfaces without area (height below 1e-12 of the longest side) are warned about.
 */
hpr_status hpr_model_check(hpr_model *model);

#endif
