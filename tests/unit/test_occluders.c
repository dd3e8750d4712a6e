/* What blocks, apart from its tessellation: merging of coplanar patches to convex polygons. */
#include "places.h"

/* Cell (x, y) of an m x n grid over origin + [0,1] e1 + [0,1] e2, as patch `at` (a square) or `at` and at + 1
 * (two triangles). Corners are rounded once each, as a file gives them. */
static void set_cell(hpr_patches *patches, size_t at, const double origin[3], const double e1[3],
                     const double e2[3], size_t m, size_t n, size_t x, size_t y, bool triangles)
{
    double corner[4][3], side[3][3];
    for (size_t c = 0; c < 4; c++) {
        double s = (double)(x + (c == 1 || c == 2)) / (double)m, t = (double)(y + (c >= 2)) / (double)n;
        hpr_add_scaled3(origin, s, e1, corner[c]);
        hpr_add_scaled3(corner[c], t, e2, corner[c]);
    }
    for (int c = 1; c < 4; c++)
        hpr_subtract3(corner[c], corner[0], side[c - 1]);
    if (triangles) {
        shapes_set(patches, at, HPR_SHAPE_TRIANGLE, corner[0], side[0], side[1]);
        shapes_set(patches, at + 1, HPR_SHAPE_TRIANGLE, corner[0], side[1], side[2]);
    } else {
        shapes_set(patches, at, HPR_SHAPE_PARALLELOGRAM, corner[0], side[0], side[2]);
    }
}

/* Backs block like fronts. */
static void turn_over(hpr_patches *patches, size_t i)
{
    double edge1[3], edge2[3];
    memcpy(edge1, patches->edge1 + 3 * i, sizeof edge1);
    memcpy(edge2, patches->edge2 + 3 * i, sizeof edge2);
    shapes_set(patches, i, (hpr_shape)patches->shape[i], patches->origin + 3 * i, edge2, edge1);
}

static double outline_area(const hpr_convex *outline)
{
    hpr_vec3 sum = {0, 0, 0};
    for (int k = 1; k + 1 < outline->count; k++)
        sum = hpr_add(sum, hpr_cross(hpr_sub(outline->corner[k], outline->corner[0]),
                                     hpr_sub(outline->corner[k + 1], outline->corner[0])));
    return hpr_length(sum) / 2;
}

static double outlines_area(const hpr_visibility *visibility)
{
    double area = 0;
    for (size_t i = 0; i < hpr_visibility_occluder_count(visibility); i++)
        area += outline_area(&hpr_visibility_outlines(visibility)[i]);
    return area;
}

/* A wall in m x n cells, numbered in random order: one occluder, with the wall's four corners. */
static void a_tessellated_wall_is_one(void **state)
{
    (void)state;
    enum { M = 9, N = 7 };
    const double e1[3] = {0.8, 0.6, 0}, e2[3] = {-0.48, 0.64, 0.6};
    hpr_context *ctx = shapes_context(1, NULL);
    uint64_t seed = 21;
    double worst = 0;
    for (int n = 0; n < 2 * PLACE_COUNT; n++) {
        const place *p = &places[n / 2];
        bool triangles = n % 2;
        double origin[3], a[3], b[3], corner[4][3];
        size_t order[M * N], step = triangles ? 2 : 1;
        put(p, (double[]){0.1, 0.2, 0.3}, origin);
        for (int k = 0; k < 3; k++) {
            a[k] = p->scale * e1[k];
            b[k] = p->scale * e2[k];
        }
        for (size_t i = 0; i < M * N; i++) {
            size_t j = (size_t)(shapes_random(&seed) * (double)(i + 1));
            order[i] = order[j];
            order[j] = i;
        }
        hpr_patches *patches = shapes_create(ctx, step * M * N);
        for (size_t i = 0; i < M * N; i++)
            set_cell(patches, step * order[i], origin, a, b, M, N, i % M, i / M, triangles);
        for (size_t i = 0; i < patches->count; i += 3)
            turn_over(patches, i);
        hpr_visibility *visibility = see(patches);
        size_t count = hpr_visibility_occluder_count(visibility);
        const hpr_convex *outline = hpr_visibility_outlines(visibility);
        if (count != 1 || outline->count != 4)
            fail_msg("place %d: %zu occluders, the first with %d corners", n / 2, count, outline->count);
        double area = p->scale * p->scale,
               unit = 8 * 0x1p-52 * (p->offset + p->scale) * p->scale + 1e-12 * area;
        worst = fmax(worst, fabs(outlines_area(visibility) - area) / (unit * 4));
        for (int k = 0; k < 4; k++) {
            hpr_add_scaled3(origin, k == 1 || k == 2, a, corner[k]);
            hpr_add_scaled3(corner[k], k >= 2, b, corner[k]);
            double nearest = INFINITY;
            for (int i = 0; i < 4; i++)
                nearest = fmin(nearest, hpr_length(hpr_sub(outline->corner[i], hpr_vec3_load(corner[k]))));
            assert_true(nearest <= unit / p->scale);
        }
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
    }
    if (worst > 1) /* the slack along the perimeter */
        fail_msg("area off by %g slacks along the perimeter", worst);
    hpr_context_destroy(&ctx);
}

/* A frame of eight cells around a hole: bars above and below, jambs left and right. */
static void a_hole_stays_open(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 8);
    const double origin[3] = {0, 0, 0}, e1[3] = {3, 0, 0}, e2[3] = {0, 3, 0};
    for (size_t i = 0, at = 0; i < 9; i++) {
        if (i != 4)
            set_cell(patches, at++, origin, e1, e2, 3, 3, i % 3, i / 3, false);
    }
    hpr_visibility *visibility = see(patches);
    uint32_t all[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    size_t count = hpr_visibility_occluder_count(visibility);
    assert_int_equal(count, 4);
    assert_true(fabs(outlines_area(visibility) - 8) < 1e-14);
    for (int i = 0; i < 9; i++) {
        double x = 0.5 + i % 3, y = 0.5 + i / 3;
        const double from[3] = {x, y, 1}, to[3] = {x, y, -1};
        assert_int_equal(hpr_visibility_blocked(visibility, from, to, all, count), i != 4);
    }
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* Two squares of which the second is bent off, moved off or cut back by `gap`; occluders that they make. */
static size_t occluders_of_two(hpr_context *ctx, double bend, double lift, double gap)
{
    hpr_patches *patches = shapes_create(ctx, 2);
    set_quad(patches, 0, 0, 0, 0, ex, ey);
    set_quad(patches, 1, 1 + gap, 0, lift, (double[]){1, 0, bend}, ey);
    hpr_visibility *visibility = see(patches);
    size_t count = hpr_visibility_occluder_count(visibility);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    return count;
}

/* The slack is 1e-12 of the scene plus rounding: 2e-12 m here. */
static void only_what_lies_in_one_plane_merges(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    assert_int_equal(occluders_of_two(ctx, 0, 0, 0), 1);
    assert_int_equal(occluders_of_two(ctx, 1e-14, 0, 0), 1);
    assert_int_equal(occluders_of_two(ctx, 1e-10, 0, 0), 2);
    assert_int_equal(occluders_of_two(ctx, 0, 1e-14, 0), 1);
    assert_int_equal(occluders_of_two(ctx, 0, 1e-10, 0), 2);
    assert_int_equal(occluders_of_two(ctx, 0, 0, 1e-14), 1);
    assert_int_equal(occluders_of_two(ctx, 0, 0, 1e-10), 2);
    hpr_context_destroy(&ctx);
}

/* A curve of many facets, each within the slack of its neighbours' planes, is not flat. */
static void small_bends_do_not_add_up(void **state)
{
    (void)state;
    enum { COUNT = 400 };
    static const double bend = 1e-13;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, COUNT);
    for (size_t i = 0; i < COUNT; i++) {
        double at = (double)i / COUNT, next = (double)(i + 1) / COUNT;
        double low = bend * COUNT * COUNT * at * at, high = bend * COUNT * COUNT * next * next;
        set_quad(patches, i, at, 0, low, (double[]){next - at, 0, high - low}, ey);
    }
    hpr_visibility *visibility = see(patches);
    double slack = 1e-12 * 2 + 1e-14, worst = 0;
    size_t count = hpr_visibility_occluder_count(visibility);
    for (size_t i = 0; i < count; i++) {
        const hpr_convex *outline = &hpr_visibility_outlines(visibility)[i];
        double low = INFINITY, high = 0;
        for (int k = 0; k < outline->count; k++) {
            low = fmin(low, outline->corner[k].x);
            high = fmax(high, outline->corner[k].x);
        }
        /* the parabola leaves its chord by a quarter of the square */
        worst = fmax(worst, bend * COUNT * COUNT * (high - low) * (high - low) / 4);
    }
    if (!(count < COUNT && worst <= slack))
        fail_msg("%zu occluders, off by %g, slack %g", count, worst, slack);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void what_lies_in_another_is_left_out(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 8);
    const double small1[3] = {0.2, 0, 0}, small2[3] = {0, 0.2, 0};
    set_quad(patches, 0, 0.4, 0.4, 0, small1, small2); /* within 1 */
    set_quad(patches, 1, 0, 0, 0, ex, ey);
    set_quad(patches, 2, 0, 0, 0, ey, ex);             /* 1 from the other side */
    set_quad(patches, 3, 0.4, 0.4, 1, small1, small2); /* elsewhere */
    set_quad(patches, 4, 0.9, 0.4, 0, small1, small2); /* sticks out */
    set_quad(patches, 5, 0, 0, 2, ex, ey);
    shapes_twin(patches, 5, 6);
    set_quad(patches, 7, 0.1, 0.4, 1e-10, small1, small2); /* above 1 by more than the slack */
    hpr_visibility *visibility = see(patches);
    assert_int_equal(hpr_visibility_occluder_count(visibility), 5);
    const hpr_convex *outline = hpr_visibility_outlines(visibility);
    const double area[5] = {1, 0.04, 0.04, 1, 0.04}, height[5] = {0, 1, 0, 2, 1e-10};
    for (int i = 0; i < 5; i++) {
        assert_true(fabs(outline_area(&outline[i]) - area[i]) < 1e-15);
        assert_true(outline[i].corner[0].z == height[i]);
    }
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* Distance of a point of the patch's plane from its outline, negative outside. */
static double depth_in(const hpr_patches *patches, size_t i, const double point[3])
{
    double corner[4][3], depth = INFINITY;
    size_t count = hpr_patch_corners(patches, i, corner);
    for (size_t k = 0; k < count; k++) {
        double edge[3], inward[3], offset[3];
        hpr_subtract3(corner[(k + 1) % count], corner[k], edge);
        hpr_cross3(patches->normal + 3 * i, edge, inward);
        hpr_subtract3(point, corner[k], offset);
        depth = fmin(depth, hpr_dot3(inward, offset) / hpr_length3(inward));
    }
    return depth;
}

/* Is the segment cut by a patch? *near: it comes too close to an outline or runs too flat to say. */
static bool cut_by_a_patch(const hpr_patches *patches, const double x[3], const double y[3], bool *near)
{
    bool cut = false;
    double best = -INFINITY; /* depth in the patch that holds the crossing best */
    *near = false;
    for (size_t i = 0; i < patches->count; i++) {
        double from_x[3], from_y[3], step[3], crossing[3];
        hpr_subtract3(x, patches->origin + 3 * i, from_x);
        hpr_subtract3(y, patches->origin + 3 * i, from_y);
        double hx = hpr_dot3(patches->normal + 3 * i, from_x), hy = hpr_dot3(patches->normal + 3 * i, from_y);
        if (hx * hy >= 0)
            continue;
        hpr_subtract3(y, x, step);
        hpr_add_scaled3(x, hx / (hx - hy), step, crossing);
        double depth = depth_in(patches, i, crossing);
        best = fmax(best, depth);
        cut |= depth >= 0;
        *near |= fabs(depth) < 1e-9 && !cut;
    }
    *near &= best < 1e-9;
    return cut;
}

/* Boxes with every side in 3 x 4 cells: whatever the patches block, the occluders block, and nothing else. */
static void occluders_block_what_the_patches_block(void **state)
{
    (void)state;
    enum { BOXES = 6, M = 3, N = 4, CELLS = M * N };
    hpr_context *ctx = shapes_context(1, NULL);
    uint64_t seed = 31;
    hpr_patches *whole = shapes_create(ctx, 6 * BOXES), *patches = shapes_create(ctx, 6 * BOXES * CELLS);
    for (size_t i = 0; i < BOXES; i++) {
        double origin[3], a[3], b[3], c[3];
        random_point(&seed, 0, 0.8, origin);
        random_direction(&seed, a);
        random_direction(&seed, c);
        hpr_cross3(a, c, b);
        double length = hpr_length3(b);
        for (int k = 0; k < 3; k++)
            b[k] /= length;
        hpr_cross3(a, b, c);
        for (int k = 0; k < 3; k++) {
            a[k] *= 0.3;
            b[k] *= 0.25;
            c[k] *= 0.35;
        }
        shapes_box(whole, 6 * i, origin, a, b, c, i % 2);
    }
    for (size_t i = 0; i < 6 * BOXES * CELLS; i++)
        set_cell(patches, i, whole->origin + 3 * (i / CELLS), whole->edge1 + 3 * (i / CELLS),
                 whole->edge2 + 3 * (i / CELLS), M, N, i % M, i % CELLS / M, false);
    hpr_visibility *visibility = see(patches);
    assert_int_equal(hpr_visibility_occluder_count(visibility), 6 * BOXES);
    uint32_t all[6 * BOXES];
    size_t counts[2] = {0};
    for (uint32_t i = 0; i < 6 * BOXES; i++)
        all[i] = i;
    for (int m = 0; m < 20000; m++) {
        double x[3], y[3];
        bool near;
        random_point(&seed, -0.2, 1.2, x);
        random_point(&seed, -0.2, 1.2, y);
        bool cut = cut_by_a_patch(patches, x, y, &near);
        if (near)
            continue;
        bool few = false, many = hpr_visibility_blocked(visibility, x, y, all, 6 * BOXES);
        for (uint32_t i = 0; i < 6 * BOXES; i++)
            few |= hpr_visibility_blocked(visibility, x, y, &i, 1);
        if (cut != many || cut != few)
            fail_msg("segment %d: patches %d, occluders %d, one by one %d", m, cut, many, few);
        counts[cut]++;
    }
    assert_true(counts[0] > 2000 && counts[1] > 2000);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_patches_destroy(&whole);
    hpr_context_destroy(&ctx);
}

/* No patch of a tessellated room is blocked by the wall that it is part of. */
static void cells_of_a_room_see_each_other_wholly(void **state)
{
    (void)state;
    enum { M = 3, CELLS = M * M };
    hpr_context *ctx = shapes_context(1, NULL);
    for (int n = 0; n < PLACE_COUNT; n++) {
        hpr_patches *room = turned_room(ctx, &places[n]), *patches = shapes_create(ctx, 6 * CELLS);
        for (size_t i = 0; i < 6 * CELLS; i++)
            set_cell(patches, i, room->origin + 3 * (i / CELLS), room->edge1 + 3 * (i / CELLS),
                     room->edge2 + 3 * (i / CELLS), M, M, i % M, i % CELLS / M, false);
        hpr_visibility *visibility = see(patches);
        assert_int_equal(hpr_visibility_occluder_count(visibility), 6);
        for (size_t a = 0; a < 6 * CELLS; a++) {
            for (size_t b = 0; b < 6 * CELLS; b++) {
                hpr_verdict verdict = classify(visibility, patches, a, b, NULL, NULL);
                if (verdict != (a / CELLS == b / CELLS ? HPR_SEES_NOTHING : HPR_SEES_WHOLLY))
                    fail_msg("place %d, cells %zu, %zu: verdict %d", n, a, b, (int)verdict);
            }
        }
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
        hpr_patches_destroy(&room);
    }
    hpr_context_destroy(&ctx);
}

/* A regular polygon as a fan of triangles: convex all along, in pieces of at most HPR_OCCLUDER_CORNERS. */
static void a_fan_becomes_a_few_polygons(void **state)
{
    (void)state;
    enum { SIDES = 40 };
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, SIDES);
    double rim[SIDES + 1][3], area = 0;
    for (int i = 0; i <= SIDES; i++) {
        double angle = 2 * 3.14159265358979323846 * (i % SIDES) / SIDES;
        rim[i][0] = cos(angle);
        rim[i][1] = sin(angle);
        rim[i][2] = 0.25;
    }
    for (size_t i = 0; i < SIDES; i++) {
        const double middle[3] = {0, 0, 0.25};
        double a[3], b[3];
        hpr_subtract3(rim[i], middle, a);
        hpr_subtract3(rim[i + 1], middle, b);
        shapes_set(patches, i, HPR_SHAPE_TRIANGLE, middle, a, b);
        area += patches->area_m2[i];
    }
    hpr_visibility *visibility = see(patches);
    size_t count = hpr_visibility_occluder_count(visibility);
    /* 16 corners hold 14 triangles of the fan, or 15 where the middle is straight */
    if (count > 4 || fabs(outlines_area(visibility) - area) > 1e-14)
        fail_msg("%zu polygons of area %.17g, expected %.17g", count, outlines_area(visibility), area);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tessellated_wall_is_one),
        cmocka_unit_test(a_hole_stays_open),
        cmocka_unit_test(only_what_lies_in_one_plane_merges),
        cmocka_unit_test(small_bends_do_not_add_up),
        cmocka_unit_test(what_lies_in_another_is_left_out),
        cmocka_unit_test(occluders_block_what_the_patches_block),
        cmocka_unit_test(cells_of_a_room_see_each_other_wholly),
        cmocka_unit_test(a_fan_becomes_a_few_polygons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
