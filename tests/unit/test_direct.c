/*
 * Direct light at points past a polygon blocker: a unit square at z = 1 lights the unit square at z = 0.
 * References to 14 digits (exact clipping and Lambert's formula in extended precision).
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "direct/direct.h"
#include "math/vec3.h"

typedef struct lit_point {
    double x, y, fraction;
} lit_point;

typedef struct blocked {
    const char *id;
    double height, corner[4][2];
    int point_count;
    lit_point point[20];
} blocked;

static const blocked cases[] = {
    {"occ_square_centre",
     0.5,
     {{0.25, 0.25}, {0.75, 0.25}, {0.75, 0.75}, {0.25, 0.75}},
     20,
     {{0.5, 0.5, 0.0},
      {0.0, 0.0, 0.120504623507886584},
      {1.0, 1.0, 0.120504623507886584},
      {0.0, 0.5, 0.119728235230386769},
      {0.5, 0.0, 0.119728235230386769},
      {0.25, 0.25, 0.104630061835206475},
      {0.75, 0.25, 0.104630061835206475},
      {0.1, 0.9, 0.128270060108738006},
      {0.9, 0.1, 0.128270060108738006},
      {0.3, 0.6, 0.0667340199555804208},
      {0.45, 0.7, 0.058211484911342023},
      {0.6, 0.35, 0.0537483942868766204},
      {0.05, 0.4, 0.119876834183700469},
      {0.95, 0.55, 0.11701564332404256},
      {0.2, 0.05, 0.127844609070576024},
      {0.33, 0.97, 0.124919864878480192},
      {0.66, 0.66, 0.0691018047161614323},
      {0.125, 0.625, 0.110967011776148714},
      {0.875, 0.375, 0.110967011776148714},
      {0.4, 0.15, 0.103855970983086423}}},
    {"occ_square_small",
     0.5,
     {{0.4375, 0.4375}, {0.5625, 0.4375}, {0.5625, 0.5625}, {0.4375, 0.5625}},
     20,
     {{0.5, 0.5, 0.21996770540896852},      {0.0, 0.0, 0.137876533919612255},
      {1.0, 1.0, 0.137876533919612255},     {0.0, 0.5, 0.177559614774340481},
      {0.5, 0.0, 0.177559614774340481},     {0.25, 0.25, 0.199001358027874158},
      {0.75, 0.25, 0.199001358027874158},   {0.1, 0.9, 0.164391772420033746},
      {0.9, 0.1, 0.164391772420033746},     {0.3, 0.6, 0.21249823959597578},
      {0.45, 0.7, 0.213732718100389136},    {0.6, 0.35, 0.215354161074840773},
      {0.05, 0.4, 0.183807265281509106},    {0.95, 0.55, 0.185193338660896699},
      {0.2, 0.05, 0.169442358249778774},    {0.33, 0.97, 0.177254708586909371},
      {0.66, 0.66, 0.212310166700703482},   {0.125, 0.625, 0.192971954030068034},
      {0.875, 0.375, 0.192971954030068034}, {0.4, 0.15, 0.197446800532263551}}},
    {"occ_near_receiver",
     0.0625,
     {{0.25, 0.25}, {0.75, 0.25}, {0.75, 0.75}, {0.25, 0.75}},
     20,
     {{0.5, 0.5, 0.0},
      {0.0, 0.0, 0.138531605994892997},
      {1.0, 1.0, 0.138531605994892997},
      {0.0, 0.5, 0.180368741123079969},
      {0.5, 0.0, 0.180368741123079969},
      {0.25, 0.25, 0.104630061835206475},
      {0.75, 0.25, 0.104630061835206475},
      {0.1, 0.9, 0.167618455113132584},
      {0.9, 0.1, 0.167618455113132584},
      {0.3, 0.6, 0.0},
      {0.45, 0.7, 0.0},
      {0.6, 0.35, 0.0},
      {0.05, 0.4, 0.188179915104620732},
      {0.95, 0.55, 0.189714659136174737},
      {0.2, 0.05, 0.172597413810635123},
      {0.33, 0.97, 0.180626996605536536},
      {0.66, 0.66, 0.0},
      {0.125, 0.625, 0.200519926614926754},
      {0.875, 0.375, 0.200519926614926754},
      {0.4, 0.15, 0.205948877967344717}}},
    {"occ_rotated",
     0.5,
     {{0.5, 0.125}, {0.875, 0.5}, {0.5, 0.875}, {0.125, 0.5}},
     20,
     {{0.5, 0.5, 0.0217757744906777505},     {0.0, 0.0, 0.119114595525545094},
      {1.0, 1.0, 0.119114595525545094},      {0.0, 0.5, 0.114247930617260015},
      {0.5, 0.0, 0.114247930617260015},      {0.25, 0.25, 0.0890588344141911747},
      {0.75, 0.25, 0.0890588344141911747},   {0.1, 0.9, 0.121892850097410649},
      {0.9, 0.1, 0.121892850097410649},      {0.3, 0.6, 0.0539394310958729074},
      {0.45, 0.7, 0.0495169034868990208},    {0.6, 0.35, 0.0433861249633757667},
      {0.05, 0.4, 0.109989421092105945},     {0.95, 0.55, 0.108510234944518001},
      {0.2, 0.05, 0.120144796750827328},     {0.33, 0.97, 0.115340068903614616},
      {0.66, 0.66, 0.0545722983284322783},   {0.125, 0.625, 0.0985190940160925504},
      {0.875, 0.375, 0.0985190940160925504}, {0.4, 0.15, 0.0914726468122858509}}},
};

static void set_patch(hpr_patches *patches, size_t i, const double (*corner)[3])
{
    hpr_vec3 origin = hpr_vec3_load(corner[0]);
    hpr_vec3 edge1 = hpr_sub(hpr_vec3_load(corner[1]), origin),
             edge2 = hpr_sub(hpr_vec3_load(corner[3]), origin);
    hpr_vec3 across = hpr_cross(edge1, edge2);
    patches->shape[i] = HPR_SHAPE_PARALLELOGRAM;
    patches->twin[i] = HPR_NONE;
    patches->area_m2[i] = hpr_length(across);
    hpr_vec3_store(patches->origin + 3 * i, origin);
    hpr_vec3_store(patches->edge1 + 3 * i, edge1);
    hpr_vec3_store(patches->edge2 + 3 * i, edge2);
    hpr_vec3_store(patches->normal + 3 * i, hpr_scale(across, 1 / patches->area_m2[i]));
}

/* Largest relative error over the case's points, through the leaves of a subdivided receiver. */
static double worst_error(hpr_context *ctx, const blocked *c, int subdivide)
{
    const double bottom[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double top[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    double blocker[4][3], worst = 0;
    hpr_patches *patches;
    hpr_elements *elements;
    hpr_direct *direct;
    for (int i = 0; i < 4; i++) {
        blocker[i][0] = c->corner[i][0];
        blocker[i][1] = c->corner[i][1];
        blocker[i][2] = c->height;
    }
    assert_int_equal(hpr_patches_create(ctx, 3, 1, &patches), HPR_OK);
    set_patch(patches, 0, bottom);
    set_patch(patches, 1, top);
    set_patch(patches, 2, (const double(*)[3])blocker);
    patches->exitance[1] = 2;
    assert_int_equal(hpr_elements_uniform(patches, 0, subdivide, &elements), HPR_OK);
    assert_true(hpr_direct_affordable(patches));
    assert_int_equal(hpr_direct_create(patches, elements, &direct), HPR_OK);
    for (int i = 0; i < c->point_count; i++) {
        double s, t, irradiance = 0;
        size_t leaf = hpr_elements_locate(patches, elements, 0, c->point[i].x, c->point[i].y, &s, &t);
        hpr_direct_add(direct, leaf, s, t, &irradiance);
        worst = fmax(worst, fabs(irradiance / (2 * c->point[i].fraction) - 1));
    }
    hpr_direct_destroy(&direct);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    return worst;
}

static void light_past_a_blocker_is_exact(void **state)
{
    (void)state;
    static const double bound = 1e-12;
    hpr_context *ctx;
    assert_int_equal(hpr_context_create(NULL, &ctx), HPR_OK);
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        for (int subdivide = 0; subdivide <= 2; subdivide++) {
            double error = worst_error(ctx, &cases[c], subdivide);
            print_message("%-18s %2d points, 4^%d leaves: error %.1e (bound %.0e)\n", cases[c].id,
                          cases[c].point_count, subdivide, error, bound);
            assert_true(error <= bound);
        }
    }
    hpr_context_destroy(&ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(light_past_a_blocker_is_exact)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
