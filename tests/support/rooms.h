/* Small scenes made by hand: parallelograms with their own reflectance and exitance, the same in all
 * channels. */
#ifndef HPR_TESTS_ROOMS_H
#define HPR_TESTS_ROOMS_H

#include "scene/scene.h"
#include "solver/solution.h"

#include <hprad/solve.h>
#include <math.h>
#include <stdio.h>

typedef struct hpr_room {
    hpr_context *context;
    hpr_scene *scene;
    uint32_t faces;
} hpr_room;

static inline hpr_room room_open(int threads)
{
    hpr_room room = {0};
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.threads = threads;
    assert_int_equal(hpr_context_create(&options, &room.context), HPR_OK);
    assert_int_equal(hpr_scene_create(room.context, "room", 3, NULL, &room.scene), HPR_OK);
    return room;
}

static inline void room_close(hpr_room *room)
{
    hpr_scene_destroy(&room->scene);
    hpr_context_destroy(&room->context);
}

/* corners: [corner_count][3], counter-clockwise from the front; 3 or 4. exitance M in W/m2. */
static inline void room_add(hpr_room *room, int corner_count, const double (*corner)[3], double reflectance,
                            double exitance, bool double_sided)
{
    const double rho[3] = {reflectance, reflectance, reflectance};
    const double radiance = exitance / 3.14159265358979323846, le[3] = {radiance, radiance, radiance};
    uint32_t material, vertex[4] = {0, 1, 2, corner_count == 4 ? 3 : HPR_NONE};
    assert_int_equal(hpr_scene_add_material(room->scene, "face", rho, le, double_sided, &material), HPR_OK);
    hpr_mesh mesh = {.node = room->faces++,
                     .material = material,
                     .vertex_count = (size_t)corner_count,
                     .position = corner[0],
                     .face_count = 1,
                     .vertex = vertex};
    assert_int_equal(hpr_scene_add_mesh(room->scene, &mesh), HPR_OK);
}

/* Two unit squares facing each other, bottom in z = 0 facing up, top in z = gap facing down. */
static inline void room_add_plates(hpr_room *room, double gap, double reflectance, double bottom_exitance)
{
    const double bottom[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double top[4][3] = {{0, 0, gap}, {0, 1, gap}, {1, 1, gap}, {1, 0, gap}};
    room_add(room, 4, bottom, reflectance, bottom_exitance, false);
    room_add(room, 4, top, reflectance, 0, false);
}

/*
 * The faces x0, x1, y0, y1, z0, z1 of the box [0,a] x [0,b] x [0,c], facing inward; `skip` (-1: none) is left
 * out. reflectance, exitance: [6].
 */
static inline void room_add_box(hpr_room *room, double a, double b, double c, const double *reflectance,
                                const double *exitance, int skip)
{
    const double face[6][4][3] = {
        {{0, 0, 0}, {0, b, 0}, {0, b, c}, {0, 0, c}}, {{a, 0, 0}, {a, 0, c}, {a, b, c}, {a, b, 0}},
        {{0, 0, 0}, {0, 0, c}, {a, 0, c}, {a, 0, 0}}, {{0, b, 0}, {a, b, 0}, {a, b, c}, {0, b, c}},
        {{0, 0, 0}, {a, 0, 0}, {a, b, 0}, {0, b, 0}}, {{0, 0, c}, {0, b, c}, {a, b, c}, {a, 0, c}}};
    for (int i = 0; i < 6; i++) {
        if (i != skip)
            room_add(room, 4, face[i], reflectance[i], exitance[i], false);
    }
}

static inline hpr_solution *room_solve_direct(hpr_room *room, int order, int subdivide,
                                              hpr_direct_mode direct)
{
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.order = order;
    options.subdivide = subdivide;
    options.direct = direct;
    hpr_solution *solution = NULL;
    hpr_status status = hpr_solve(room->context, room->scene, &options, &solution);
    if (status != HPR_OK)
        print_error("solve: %s\n", hpr_context_error(room->context));
    assert_int_equal(status, HPR_OK);
    return solution;
}

static inline hpr_solution *room_solve(hpr_room *room, int order, int subdivide)
{
    return room_solve_direct(room, order, subdivide, HPR_DIRECT_EXACT);
}

/* Distance of the coefficients of the irradiance, relative to those of `a`; three channels, the same
 * elements. */
static inline double room_difference(const hpr_solution *a, const hpr_solution *b)
{
    double d2 = 0, n2 = 0;
    for (size_t i = 0; i < 3 * hpr_solution_summary(a)->dof_count; i++) {
        d2 += (a->irradiance[i] - b->irradiance[i]) * (a->irradiance[i] - b->irradiance[i]);
        n2 += a->irradiance[i] * a->irradiance[i];
    }
    return sqrt(d2 / n2);
}

/* Radiosity of the first channel at a point of the patch whose front `normal` points to. */
static inline double room_radiosity(hpr_room *room, const hpr_solution *solution, const double point[3],
                                    const double normal[3])
{
    double irradiance[3], radiosity[3];
    uint32_t patch;
    assert_int_equal(
        hpr_solution_probe(room->context, solution, 1, point, normal, irradiance, radiosity, &patch), HPR_OK);
    assert_int_not_equal(patch, HPR_NONE);
    return radiosity[0];
}

/* Largest relative error of B (1 - rho) = 1 at 5 x 5 points of each parallelogram, edges and corners
 * included.
 */
static inline double room_furnace_error(hpr_room *room, const hpr_solution *solution, double rho)
{
    enum { PATCHES_MAX = 6, EACH = 25 };
    static double point[PATCHES_MAX * EACH][3], normal[PATCHES_MAX * EACH][3];
    static double irradiance[PATCHES_MAX * EACH][3], radiosity[PATCHES_MAX * EACH][3];
    static uint32_t found[PATCHES_MAX * EACH];
    const hpr_patches *patches = solution->patches;
    size_t count = EACH * patches->count;
    assert_in_range(patches->count, 1, PATCHES_MAX);
    for (size_t i = 0; i < count; i++) {
        size_t patch = i / EACH;
        double s = (double)(i % 5) / 4, t = (double)(i / 5 % 5) / 4;
        for (size_t k = 0; k < 3; k++) {
            point[i][k] = patches->origin[3 * patch + k] + s * patches->edge1[3 * patch + k] +
                          t * patches->edge2[3 * patch + k];
            normal[i][k] = patches->normal[3 * patch + k];
        }
    }
    assert_int_equal(hpr_solution_probe(room->context, solution, count, point[0], normal[0], irradiance[0],
                                        radiosity[0], found),
                     HPR_OK);
    double worst = 0;
    for (size_t i = 0; i < count; i++) {
        assert_int_not_equal(found[i], HPR_NONE);
        worst = fmax(worst, fabs(radiosity[i][0] * (1 - rho) - 1));
    }
    return worst;
}

#endif
