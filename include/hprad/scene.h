#ifndef HPRAD_SCENE_H
#define HPRAD_SCENE_H

#include <hprad/context.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Faces, materials and cameras in world space. Independent of any file format. */
typedef struct hpr_scene hpr_scene;

/** "No index": absent material, absent fourth vertex of a triangle. */
#define HPR_NONE UINT32_MAX

/** How a glTF file is read. */
typedef struct hpr_read_options {
    int scene_index;        /**< which of the file's scenes; -1: its default, else the first */
    int metallic_black;     /**< 0: the metallic part of a material counts as diffuse; 1: it is black */
    double max_reflectance; /**< > 0: reflectances above it are scaled down to it; 0: left alone */
} hpr_read_options;

HPR_API void hpr_read_options_init(hpr_read_options *options);

/**
 * Reads a glTF 2.0 file (.gltf with separate or embedded data, or .glb) in double precision world space.
 * Errors: HPR_ERR_IO (cannot be read), HPR_ERR_FORMAT (breaks glTF, out-of-range accessor, rho > 1, ...),
 * HPR_ERR_UNSUPPORTED (a required extension), HPR_ERR_MEMORY. `options` may be NULL.
 */
HPR_API hpr_status hpr_scene_read(hpr_context *context, const char *path, const hpr_read_options *options,
                                  hpr_scene **scene);

/**
 * Reads only the cameras of a glTF file, of which there may be none: a scene without faces. Errors: as
 * hpr_scene_read.
 */
HPR_API hpr_status hpr_scene_read_cameras(hpr_context *context, const char *path,
                                          const hpr_read_options *options, hpr_scene **scene);

/**
 * Lets the same radiance L come from all directions outside, W/m²/sr, to be seen by surfaces and cameras; 0
 * when a scene is made. radiance: [count], one number for all channels (count 1) or one for each. Copied.
 * Errors: HPR_ERR_ARG (another count, or a number that is not finite and >= 0; the scene then stays as it
 * was). No concurrent calls on one scene.
 */
HPR_API hpr_status hpr_scene_set_environment(hpr_scene *scene, size_t count, const double *radiance);

/** Frees it; accepts NULL and sets NULL. */
HPR_API void hpr_scene_destroy(hpr_scene **scene);

#ifdef __cplusplus
}
#endif

#endif
