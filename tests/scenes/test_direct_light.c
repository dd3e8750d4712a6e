/*
 * Direct light at random points of the Cornell box, penumbra included, by clipping here and by stratified
 * shadow samples there, which share nothing with the library but the scene's arrays:
 *   D = sum over cells of the lamp of M cosθ_x cosθ_y V / (π r²) A / N², one random point in each of N x N.
 * test_direct_light [N] takes N = 120; 2237 makes ten million samples on the two triangles for each point.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "rooms.h"

#include <omp.h>

enum { POINTS = 200, CHANNELS = 3, FACES_MAX = 64 };

static int side = 120;

typedef struct face {
    double corner[3], edge1[3], edge2[3], normal[3], area_m2, exitance[CHANNELS];
} face;

typedef struct faces {
    size_t count;
    face face[FACES_MAX]; /* triangles */
} faces;

typedef struct sample {
    double point[3], normal[3], solved[CHANNELS], mean[CHANNELS], error[CHANNELS];
    double seen; /* share of the samples that the point sees */
} sample;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; k++)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* splitmix64 */
static double random_unit(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static void add_face(faces *all, const hpr_scene *scene, size_t index, const uint32_t v[3])
{
    uint32_t material = scene->mesh_material[scene->face_mesh[index]];
    face *f = &all->face[all->count++];
    assert_true(all->count <= FACES_MAX);
    for (size_t k = 0; k < 3; k++) {
        f->corner[k] = scene->position[3 * (size_t)v[0] + k];
        f->edge1[k] = scene->position[3 * (size_t)v[1] + k] - f->corner[k];
        f->edge2[k] = scene->position[3 * (size_t)v[2] + k] - f->corner[k];
    }
    cross(f->edge1, f->edge2, f->normal);
    double length = sqrt(dot(f->normal, f->normal));
    f->area_m2 = length / 2;
    for (size_t k = 0; k < 3; k++) {
        f->normal[k] /= length;
        f->exitance[k] = material == HPR_NONE
                             ? 0
                             : 3.14159265358979323846 * scene->material_radiance[CHANNELS * material + k];
    }
}

/* Does a face cut the open segment from x to x + d? Ends within a billionth do not count. */
static bool blocks(const face *f, const double x[3], const double d[3])
{
    static const double end = 1e-9;
    double p[3], q[3], from[3];
    for (int k = 0; k < 3; k++)
        from[k] = x[k] - f->corner[k];
    double height = -dot(from, f->normal), way = dot(d, f->normal);
    if (height * way <= 0 || fabs(height) >= fabs(way))
        return false; /* the plane is not between them */
    cross(d, f->edge2, p);
    double det = dot(f->edge1, p);
    double u = dot(from, p) / det;
    cross(from, f->edge1, q);
    double v = dot(d, q) / det, t = dot(f->edge2, q) / det;
    return u >= 0 && v >= 0 && u + v <= 1 && t > end && t < 1 - end;
}

static void read_faces(const hpr_scene *scene, faces *all)
{
    for (size_t i = 0; i < scene->face_count; i++) {
        const uint32_t *v = scene->face_vertex + 4 * i;
        add_face(all, scene, i, v);
        if (v[3] != HPR_NONE)
            add_face(all, scene, i, (uint32_t[]){v[0], v[2], v[3]});
    }
}

/* A point of a triangle, by the map of the unit square that keeps areas. */
static void triangle_point(const face *f, double a, double b, double point[3])
{
    double root = sqrt(a);
    for (int k = 0; k < 3; k++)
        point[k] = f->corner[k] + (1 - root) * f->edge1[k] + b * root * f->edge2[k];
}

/* cosθ_x cosθ_y V A / (π r²) for a point of a lamp. */
static double transfer(const faces *all, const face *lamp, const sample *x, const double y[3], bool *seen)
{
    double d[3];
    for (int k = 0; k < 3; k++)
        d[k] = y[k] - x->point[k];
    double here = dot(d, x->normal), there = -dot(d, lamp->normal), square = dot(d, d);
    if (here <= 0 || there <= 0)
        return 0;
    for (size_t i = 0; i < all->count; i++) {
        if (blocks(&all->face[i], x->point, d))
            return 0;
    }
    *seen = true;
    return here * there * lamp->area_m2 / (3.14159265358979323846 * square * square);
}

/* Neighbouring strata in pairs give the variance: half the mean square of their difference, per stratum. */
static void add_lamp(const faces *all, const face *lamp, uint64_t *seed, sample *x)
{
    double sum = 0, squares = 0, last = 0, n = side, seen = 0;
    for (int i = 0; i < side * side; i++) {
        double a = (i / side + random_unit(seed)) / n, b = (i % side + random_unit(seed)) / n, y[3];
        bool hit = false;
        triangle_point(lamp, a, b, y);
        double value = transfer(all, lamp, x, y, &hit);
        sum += value;
        seen += hit;
        if (i % 2)
            squares += (value - last) * (value - last);
        last = value;
    }
    x->seen += seen / (n * n);
    for (int c = 0; c < CHANNELS; c++) {
        x->mean[c] += lamp->exitance[c] * sum / (n * n);
        x->error[c] = hypot(x->error[c], lamp->exitance[c] * sqrt(squares) / (n * n));
    }
}

/* With everything black, irradiance is direct light. */
static hpr_solution *solve_black(hpr_context *ctx, hpr_scene **scene)
{
    static const double black = 1e-9;
    hpr_solution *solution = NULL;
    hpr_read_options read;
    hpr_solve_options options;
    hpr_read_options_init(&read);
    hpr_solve_options_init(&options);
    read.max_reflectance = black;
    options.order = options.subdivide = options.feet = 0;
    assert_int_equal(hpr_scene_read(ctx, HPRAD_SCENES "/cornell_box.gltf", &read, scene), HPR_OK);
    assert_int_equal(hpr_solve(ctx, *scene, &options, &solution), HPR_OK);
    return solution;
}

static void place(const hpr_patches *patches, uint64_t *seed, sample *x)
{
    size_t patch = (size_t)(random_unit(seed) * (double)patches->count);
    double u = random_unit(seed), v = random_unit(seed), at[2];
    hpr_shape_uniform((hpr_shape)patches->shape[patch], patches->opposite + 2 * patch, u, v, at);
    *x = (sample){0};
    for (size_t k = 0; k < 3; k++) {
        x->normal[k] = patches->normal[3 * patch + k];
        x->point[k] = patches->origin[3 * patch + k] + at[0] * patches->edge1[3 * patch + k] +
                      at[1] * patches->edge2[3 * patch + k];
    }
}

static void probe_all(hpr_context *ctx, const hpr_solution *solution, sample *points)
{
    static double point[POINTS][3], normal[POINTS][3], irradiance[POINTS][CHANNELS],
        radiosity[POINTS][CHANNELS];
    static uint32_t found[POINTS];
    for (int i = 0; i < POINTS; i++) {
        memcpy(point[i], points[i].point, sizeof *point);
        memcpy(normal[i], points[i].normal, sizeof *normal);
    }
    assert_int_equal(
        hpr_solution_probe(ctx, solution, POINTS, point[0], normal[0], irradiance[0], radiosity[0], found),
        HPR_OK);
    for (int i = 0; i < POINTS; i++)
        memcpy(points[i].solved, irradiance[i], sizeof *irradiance);
}

static void clipped_lamps_agree_with_shadow_samples(void **state)
{
    (void)state;
    static const double deviations = 4.1; /* P(|z| > 4.1) POINTS = 0.8% */
    static sample points[POINTS];
    faces all = {0};
    hpr_context *ctx = NULL;
    hpr_scene *scene = NULL;
    assert_int_equal(hpr_context_create(NULL, &ctx), HPR_OK);
    hpr_solution *solution = solve_black(ctx, &scene);
    read_faces(scene, &all);
    uint64_t seed = 3;
    for (int i = 0; i < POINTS; i++)
        place(solution->patches, &seed, &points[i]);
    probe_all(ctx, solution, points);
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
    for (int i = 0; i < POINTS; i++) {
        uint64_t own = 1000 + (uint64_t)i;
        for (size_t k = 0; k < all.count; k++) {
            if (all.face[k].exitance[0] > 0)
                add_lamp(&all, &all.face[k], &own, &points[i]);
        }
    }
    double worst = 0, off2 = 0, error2 = 0, sum2 = 0;
    int lit = 0, penumbra = 0;
    for (int i = 0; i < POINTS; i++) {
        const sample *x = &points[i];
        double off = fabs(x->solved[0] - x->mean[0]);
        /* the light that walls of 1e-9 reflect, below 1e-8 of the brightest point's 5 W/m2; and where no
         * sample sees the lamp, one sample of it, for then there is no estimate of the error */
        double least = x->mean[0] > 0 ? 5e-8 : 5.0 / (2.0 * side * side);
        worst = fmax(worst, off / (x->error[0] + least));
        lit += x->mean[0] > 0;
        penumbra += x->seen > 0 && x->seen < 1.999; /* of two triangles */
        off2 += off * off;
        error2 += x->error[0] * x->error[0];
        sum2 += x->mean[0] * x->mean[0];
    }
    print_message(
        "%d points, %d of them lit and %d see a part of the lamp; 2 x %d samples each: at most %.2f "
        "standard errors apart; RMS difference %.2g, standard error %.2g of the RMS\n",
        POINTS, lit, penumbra, side * side, worst, sqrt(off2 / sum2), sqrt(error2 / sum2));
    assert_true(penumbra >= POINTS / 20);
    assert_true(worst <= deviations);
    hpr_solution_destroy(&solution);
    hpr_scene_destroy(&scene);
    hpr_context_destroy(&ctx);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clipped_lamps_agree_with_shadow_samples),
    };
    side = argc > 1 ? atoi(argv[1]) : side;
    if (side < 2)
        return 2;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
