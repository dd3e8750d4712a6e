/*
 * An independent estimate of irradiance: path tracing in double over the faces of a scene, by brute force. It
 * shares nothing with the library but the scene's arrays. Single-sided faces are black on their back and
 * block there.
 */
#ifndef HPR_TESTS_PATH_ESTIMATE_H
#define HPR_TESTS_PATH_ESTIMATE_H

#include "scene/scene.h"

#include <stddef.h>
#include <stdint.h>

enum { PATH_CHANNELS = 3 };

typedef struct path_scene path_scene;

/* Copies what it needs; a scene of up to PATH_CHANNELS channels. Reflectance is each face's mean. NULL
 * without memory. Freed by path_scene_destroy. */
path_scene *path_scene_create(const hpr_scene *scene);
void path_scene_destroy(path_scene *scene);

typedef struct path_result {
    double mean[PATH_CHANNELS]; /* irradiance, W/m2 */
    /* Standard error of the mean as if the paths were independent: an upper bound, strata only lower it. */
    double error[PATH_CHANNELS];
} path_result;

/*
 * side * side paths from a point that lies on a face, about its unit normal: cosine-weighted directions and
 * points of the emitters, both stratified at the first vertex, joined by the balance heuristic (Veach &
 * Guibas 1995); Russian roulette from the fifth vertex on. The same seed gives the same bits. Thread-safe.
 */
void path_estimate(const path_scene *scene, const double point[3], const double normal[3], size_t side,
                   uint64_t seed, path_result *result);

#endif
