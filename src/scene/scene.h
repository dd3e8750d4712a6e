/*
 * The scene as plain arrays. A scene is built once (add_material, add_mesh, add_camera), validated, and then
 * only read. Vertices are as the file has them, in world space; welding is the patch builder's business.
 */
#ifndef HPR_SCENE_SCENE_H
#define HPR_SCENE_SCENE_H

#include "base/context.h"
#include "scene/texture.h"

#include <hprad/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct hpr_material {
    char *name;
    bool double_sided;
} hpr_material;

typedef enum hpr_camera_kind { HPR_CAMERA_PERSPECTIVE, HPR_CAMERA_ORTHOGRAPHIC } hpr_camera_kind;

typedef struct hpr_camera {
    char *name; /* "" if the file gives none */
    hpr_camera_kind kind;
    double origin[3];                    /* world, metres */
    double right[3], up[3], backward[3]; /* world, orthonormal; the camera looks along -backward */
    double yfov_rad;                     /* perspective */
    double aspect;                       /* width / height, 0: that of the picture */
    double xmag, ymag;                   /* orthographic: half width and half height, metres */
    double znear, zfar;                  /* zfar = INFINITY if open */
} hpr_camera;

/* A mesh of one node and one primitive as it is added; every array is copied. */
typedef struct hpr_mesh {
    const char *name; /* name for messages and tables, may be NULL */
    uint32_t node, primitive;
    uint32_t material; /* index, or HPR_NONE: reflectance 0.8, no emission */
    size_t vertex_count;
    const double *position; /* [vertex_count][3], world */
    const double *uv;       /* [vertex_count][2] or NULL: none */
    const double *colour;   /* [vertex_count][channels] or NULL: all ones */
    const double *glow_uv;  /* [vertex_count][2] or NULL: none */
    size_t face_count;
    const uint32_t *vertex; /* [face_count][4], counter-clockwise from the front; [3] = HPR_NONE: triangle */
    const double *face_reflectance; /* [face_count][channels]: area mean of rho, textures and colours
                                       included, or NULL: the material's */
    uint32_t texture;               /* index, if there is a factor */
    const double *factor; /* [channels] rho = factor * colour * texture(uv), of which face_reflectance must be
                             the mean; or NULL: no texture */
    const double *face_radiance; /* [face_count][channels]: area mean of what is emitted, W/m2/sr; or NULL:
                                    the material's */
    uint32_t glow_texture;       /* index, if there is a factor */
    const double *glow_factor; /* [channels] radiance = factor * texture(glow_uv), of which face_radiance must
                                  be the mean; or NULL: no texture */
} hpr_mesh;

struct hpr_scene {
    hpr_context *context;
    char *path; /* of the file it came from, "" if none */
    size_t channel_count;
    char **channel_name; /* [channel_count] */
    double *environment; /* [channel_count] radiance from outside, W/m2/sr */

    size_t material_count, material_capacity;
    hpr_material *material;
    double *material_reflectance; /* [material_count][channels] */
    double *material_radiance;    /* [material_count][channels], emitted, W/m2/sr; without texture */

    size_t vertex_count, vertex_capacity;
    double *position; /* [vertex_count][3] */
    double *uv;       /* [vertex_count][2], NaN where a mesh has none */
    double *colour;   /* [vertex_count][channels] */
    double *glow_uv;  /* [vertex_count][2], of the emissive texture, NaN where a mesh has none */

    size_t mesh_count, mesh_capacity;
    char **mesh_name;                                     /* [mesh_count] "" if none */
    uint32_t *mesh_node, *mesh_primitive, *mesh_material; /* [mesh_count] */
    uint32_t *mesh_texture;                               /* [mesh_count] or HPR_NONE */
    double *mesh_factor;                                  /* [mesh_count][channels] of a texture */
    uint32_t *mesh_glow_texture;                          /* [mesh_count] or HPR_NONE */
    double *mesh_glow_factor;                             /* [mesh_count][channels] W/m2/sr */

    size_t texture_count, texture_capacity;
    hpr_texture *texture;

    size_t face_count, face_capacity;
    uint32_t *face_vertex;    /* [face_count][4] into position */
    uint32_t *face_mesh;      /* [face_count] */
    double *face_reflectance; /* [face_count][channels] */
    double *face_radiance;    /* [face_count][channels], mean, W/m2/sr */

    size_t camera_count, camera_capacity;
    hpr_camera *camera;
};

/* `channel_name` NULL: R, G, B and channel_count must be 3. */
hpr_status hpr_scene_create(hpr_context *ctx, const char *path, size_t channel_count,
                            const char *const *channel_name, hpr_scene **scene);

/* reflectance and radiance: [channels]. Errors: HPR_ERR_FORMAT if a value is not finite or negative, or if
 * rho > 1 (the message names the material). */
hpr_status hpr_scene_add_material(hpr_scene *scene, const char *name, const double *reflectance,
                                  const double *radiance, bool double_sided, uint32_t *index);

/* Copies the texture. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_scene_add_texture(hpr_scene *scene, const hpr_texture *texture, uint32_t *index);

/* Errors: HPR_ERR_FORMAT if a position is not finite, an index is out of range, a face's rho is not in [0, 1]
 * or its radiance is not finite or negative. */
hpr_status hpr_scene_add_mesh(hpr_scene *scene, const hpr_mesh *mesh);

/* Copies the camera and its name. Errors: HPR_ERR_FORMAT if it is not finite or its frustum is empty. */
hpr_status hpr_scene_add_camera(hpr_scene *scene, const hpr_camera *camera);

/* Scales every material and face whose reflectance is above `limit` in some channel down to it (all channels
 * by the same factor) and says so; a mesh with a texture as a whole, by the largest product of its factor, a
 * vertex colour and a texel. Errors: HPR_ERR_ARG unless 0 < limit <= 1. */
hpr_status hpr_scene_limit_reflectance(hpr_scene *scene, double limit);

/* Corners of the axis-parallel box of all face vertices; false if there is no face. */
bool hpr_scene_bounds(const hpr_scene *scene, double low[3], double high[3]);

#ifdef __cplusplus
}
#endif

#endif
