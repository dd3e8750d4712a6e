#include "places.h"

#include <omp.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

/* A segment of the hard kinds too: ends on, or a hair off, a patch's plane, or through an edge. */
static void random_segment(const hpr_patches *patches, const place *p, uint64_t *seed, int kind, double x[3],
                           double y[3])
{
    size_t i = (size_t)(shapes_random(seed) * (double)patches->count);
    size_t j = (size_t)(shapes_random(seed) * (double)patches->count);
    random_point(seed, -0.2, 1.2, x);
    put(p, x, x);
    random_point(seed, -0.2, 1.2, y);
    put(p, y, y);
    if (kind >= 1 && kind <= 3) { /* from patch to patch, as quadrature points are */
        point_on(patches, i, shapes_random(seed), shapes_random(seed), x);
        point_on(patches, j, shapes_random(seed), shapes_random(seed), y);
        double lift = kind == 1 ? 0 : kind == 2 ? 1e-9 : 1e-7;
        hpr_add_scaled3(x, p->scale * lift, patches->normal + 3 * i, x);
        hpr_add_scaled3(y, p->scale * lift, patches->normal + 3 * j, y);
    } else if (kind == 4) { /* nearly in the plane of a patch, ends a hair on both sides of it */
        point_on(patches, i, shapes_random(seed), 2 * shapes_random(seed) - 0.5, x);
        point_on(patches, i, 2 * shapes_random(seed) - 0.5, shapes_random(seed), y);
        double lift = pow(10, -12 + 8 * shapes_random(seed));
        hpr_add_scaled3(x, p->scale * lift, patches->normal + 3 * i, x);
        hpr_add_scaled3(y, -p->scale * lift, patches->normal + 3 * i, y);
    } else if (kind == 5) { /* through a point of an edge */
        double edge[3];
        point_on(patches, i, 0, shapes_random(seed), edge);
        hpr_subtract3(edge, x, y);
        hpr_add_scaled3(edge, 0.9, y, y);
    } else if (kind == 6) { /* from far away */
        hpr_add_scaled3(x, 1e4, y, x);
    }
}

static void tree_agrees_with_the_plain_loop(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    uint64_t seed = 7;
    size_t blocked_count[7] = {0}, total[7] = {0};
    for (int n = 0; n < 2 * PLACE_COUNT; n++) {
        const place *p = &places[n % PLACE_COUNT];
        hpr_patches *patches = random_scene(ctx, &seed, p);
        hpr_visibility *visibility = see(patches);
        for (int m = 0; m < 30000; m++) {
            double x[3], y[3];
            uint32_t list[RANDOM_COUNT];
            size_t count = 0;
            random_segment(patches, p, &seed, m % 7, x, y);
            double share = m % 2 ? 1 : 0.5;
            for (uint32_t i = 0; i < RANDOM_COUNT; i++) {
                if (shapes_random(&seed) < share)
                    list[count++] = i;
            }
            bool plain = false;
            for (size_t i = 0; i < count && !plain; i++)
                plain = hpr_visibility_blocked(visibility, x, y, &list[i], 1);
            bool tree = hpr_visibility_blocked(visibility, x, y, list, count);
            if (plain != tree)
                fail_msg("place %d, segment %d of kind %d: loop %d, tree %d", n, m, m % 7, plain, tree);
            blocked_count[m % 7] += plain;
            total[m % 7]++;
        }
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
    }
    for (int kind = 0; kind < 7; kind++) /* the test is worth something only if both answers occur */
        assert_true(20 * blocked_count[kind] > total[kind] &&
                    20 * (total[kind] - blocked_count[kind]) > total[kind]);
    hpr_context_destroy(&ctx);
}

/* Two blockers that share an edge, folded by different angles: nothing passes through the edge. */
static void no_leak_between_blockers(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    uint64_t seed = 3;
    for (int n = 0; n < 4 * PLACE_COUNT; n++) {
        const place *p = &places[n % PLACE_COUNT];
        hpr_patches *patches = shapes_create(ctx, 20);
        double origin[3], edge[3], wing1[3], wing2[3], far[3], along[3];
        random_point(&seed, 0, 1, origin);
        put(p, origin, origin);
        random_direction(&seed, edge);
        random_direction(&seed, wing1);
        random_direction(&seed, wing2);
        for (int k = 0; k < 3; k++) {
            edge[k] *= p->scale;
            wing1[k] *= p->scale;
            wing2[k] = p->scale * (n < PLACE_COUNT ? 0 : wing2[k]) - wing1[k]; /* coplanar first */
        }
        /* as a file gives it: the shared edge from its other end, its vertices rounded once more */
        hpr_add_scaled3(origin, 1, edge, far);
        hpr_subtract3(origin, far, along);
        shapes_set(patches, 0, HPR_SHAPE_PARALLELOGRAM, origin, edge, wing1);
        shapes_set(patches, 1, n % 2 ? HPR_SHAPE_TRIANGLE : HPR_SHAPE_PARALLELOGRAM, far, along, wing2);
        for (size_t i = 2; i < 20; i++) { /* out of the way; a long list goes through the tree */
            double away[3] = {5 * p->scale + p->offset, p->offset, p->offset + (double)i * p->scale};
            shapes_set(patches, i, HPR_SHAPE_TRIANGLE, away, edge, wing1);
        }
        hpr_visibility *visibility = see(patches);
        uint32_t all[20];
        for (uint32_t i = 0; i < 20; i++)
            all[i] = i;
        for (int m = 0; m < 20000; m++) {
            double between = 1e-3 + 0.998 * shapes_random(&seed), x[3], y[3], point[3], direction[3], span[3];
            hpr_add_scaled3(origin, between, edge, point);
            /* a direction from one side of the fold to the other: across the mean of both normals */
            random_direction(&seed, direction);
            double sign[2];
            for (int w = 0; w < 2; w++)
                sign[w] = hpr_dot3(direction, patches->normal + 3 * w);
            /* passes the edge from one side to the other if the wings lie on different sides of the plane
             * spanned by the ray and the edge */
            hpr_cross3(direction, edge, span);
            if (hpr_dot3(span, wing1) * hpr_dot3(span, wing2) >= 0 || fabs(sign[0]) < 1e-4 ||
                fabs(sign[1]) < 1e-4)
                continue;
            hpr_add_scaled3(point, 0.7 * p->scale, direction, x);
            hpr_add_scaled3(point, -0.4 * p->scale, direction, y);
            if (!hpr_visibility_blocked(visibility, x, y, all, 2) ||
                !hpr_visibility_blocked(visibility, x, y, all, 20))
                fail_msg("fold %d: ray %d leaks through the edge", n, m);
        }
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
    }
    hpr_context_destroy(&ctx);
}

/* From inside a closed room every ray ends on a wall, also those that aim at edges and corners. */
static void no_leak_from_a_room(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    uint64_t seed = 5;
    for (int n = 0; n < PLACE_COUNT; n++) {
        const place *p = &places[n];
        hpr_patches *patches = turned_room(ctx, p);
        hpr_visibility *visibility = see(patches);
        for (int m = 0; m < 200000; m++) {
            double inside[3], target[3], direction[3];
            for (int k = 0; k < 3; k++)
                inside[k] = patches->origin[k];
            for (size_t w = 0; w < 3; w++) /* patches 0, 2, 4 start in the corner */
                hpr_add_scaled3(inside, 0.01 + 0.98 * shapes_random(&seed), patches->edge1 + 3 * 2 * w,
                                inside);
            size_t wall = (size_t)m % 6;
            int kind = m % 4;
            point_on(patches, wall, kind == 3 ? 1 : shapes_random(&seed),
                     kind >= 2 ? 0 : shapes_random(&seed), target);
            hpr_subtract3(target, inside, direction);
            double length = hpr_length3(direction);
            for (int k = 0; k < 3; k++)
                direction[k] /= length;
            hpr_hit hit = hpr_visibility_first_hit(visibility, inside, direction, 0, INFINITY, true, NULL);
            if (hit.patch == HPR_NONE)
                fail_msg("place %d: ray %d at wall %zu escapes", n, m, wall);
            if (kind < 2)
                assert_int_equal(hit.patch, wall);
            /* the point that is hit is the one aimed at: 8 eps of the coordinates over the cosine, which is
             * at least 0.01 / 1.73; worst seen is a tenth of that */
            double limit = 200 * 8 * 0x1p-52 * (p->scale + p->offset);
            if (fabs(hit.distance - length) > limit)
                fail_msg("place %d: ray %d ends at %.17g, not %.17g", n, m, hit.distance, length);
        }
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
    }
    hpr_context_destroy(&ctx);
}

/* Rays are cut to a ball around the scene: one that just holds the corners of a room, seen from in- and
 * outside. */
static void outermost_corners_are_reached(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 18);
    double side = 2 / sqrt(3) * (1 - 1e-12), a[3] = {side, 0, 0}, b[3] = {0, side, 0}, c[3] = {0, 0, side};
    const double corner[3] = {-side / 2, -side / 2, -side / 2};
    shapes_box(patches, 0, corner, a, b, c, true); /* half the diagonal is just below 1 */
    uint32_t walls[18];
    for (uint32_t i = 0; i < 18; i++)
        walls[i] = i;
    hpr_visibility *visibility = see(patches);
    uint64_t seed = 19;
    for (int m = 0; m < 8000; m++) {
        double from[3], target[3], direction[3], beyond[3];
        random_point(&seed, -0.2, 0.2, from);
        for (int k = 0; k < 3; k++) /* within 1e-9 of a corner, inside */
            target[k] = (m >> k & 1 ? 1 : -1) * (side / 2 - 1e-9 * shapes_random(&seed));
        hpr_subtract3(target, from, direction);
        double length = hpr_length3(direction);
        for (int k = 0; k < 3; k++)
            direction[k] /= length;
        hpr_hit hit = hpr_visibility_first_hit(visibility, from, direction, 0, INFINITY, true, NULL);
        assert_true(hit.patch != HPR_NONE && fabs(hit.distance - length) < 1e-8);
        /* from 5 away on the other side, through the culled back of a wall to the same corner */
        hpr_add_scaled3(target, -5, direction, from);
        hit = hpr_visibility_first_hit(visibility, from, direction, 0, INFINITY, true, NULL);
        assert_true(hit.patch != HPR_NONE && fabs(hit.distance - 5) < 1e-8);
        /* and a segment that begins near the corner, outside, is blocked there */
        hpr_add_scaled3(target, -1e-3, direction, from);
        hpr_add_scaled3(target, 3, direction, beyond);
        assert_true(hpr_visibility_blocked(visibility, from, beyond, walls, 18));
    }
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void ties_go_to_the_lowest_index(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 6);
    const size_t order[6] = {3, 5, 0, 4, 1, 2}; /* a 3 x 2 pavement, numbered out of order */
    for (size_t i = 0; i < 6; i++)
        set_quad(patches, order[i], (double)(i % 3), (double)(i / 3), 0, ex, ey);
    hpr_visibility *visibility = see(patches);
    assert_int_equal(look_down(visibility, 0.5, 0.5, 1, true, NULL).patch, 3);
    assert_int_equal(look_down(visibility, 1, 0.5, 1, true, NULL).patch, 3); /* 3 | 5 */
    assert_int_equal(look_down(visibility, 2, 0.5, 1, true, NULL).patch, 0); /* 5 | 0 */
    assert_int_equal(look_down(visibility, 1, 1, 1, true, NULL).patch, 1);   /* 3 5 4 1 */
    assert_int_equal(look_down(visibility, 2, 1, 1, true, NULL).patch, 0);   /* 5 0 1 2 */
    assert_int_equal(look_down(visibility, 2.5, 1, 1, true, NULL).patch, 0); /* 0 2 */
    assert_int_equal(look_down(visibility, 3.01, 1, 1, true, NULL).patch, HPR_NONE);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* Oblique, so that distances to the two differ by rounding: two sheets of one plane must not show through
 * each other, and of a wall of two faces the one that faces the ray is met. */
static void what_lies_in_one_plane_does_not_flicker(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 3);
    const double a[3] = {0.9, 0.1, 0.37}, b[3] = {-0.23, 0.8, 0.41};
    double low[3], wide[3], high[3], across[3];
    for (int k = 0; k < 3; k++) {
        low[k] = 0.1 * a[k] + 0.2 * b[k];
        wide[k] = 0.7 * a[k] + 0.13 * b[k];
        high[k] = 0.6 * b[k] - 0.07 * a[k];
    }
    set_quad(patches, 0, low[0], low[1], low[2], high, wide); /* faces away from the others */
    set_quad(patches, 1, 0, 0, 0, a, b);
    set_quad(patches, 2, low[0], low[1], low[2], wide, high);
    hpr_visibility *visibility = see(patches);
    uint64_t seed = 17;
    hpr_cross3(a, b, across);
    for (int i = 0; i < 2000; i++) {
        double target[3], origin[3], direction[3], u[3];
        bool back = true, behind = i % 2;
        random_point(&seed, 0.3, 0.6, u);
        random_direction(&seed, direction);
        if ((hpr_dot3(direction, across) > 0) != behind)
            hpr_add_scaled3(direction, -2, direction, direction);
        for (int k = 0; k < 3; k++) {
            target[k] = u[0] * a[k] + u[1] * b[k];
            origin[k] = target[k] - 2 * direction[k];
        }
        hpr_hit hit = hpr_visibility_first_hit(visibility, origin, direction, 0, INFINITY, false, &back);
        assert_int_equal(hit.patch, behind ? 0 : 1);
        assert_false(back);
    }
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* As coverage has it: the floor under a sheet gets no light. */
static void a_sheet_hides_what_it_lies_on(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 3);
    const double wide[3] = {2, 0, 0}, deep[3] = {0, 2, 0};
    set_quad(patches, 0, 0, 0, 0, wide, deep);
    set_quad(patches, 1, 0.5, 0.5, 0, ex, ey);
    shapes_twin(patches, 1, 2);
    hpr_visibility *visibility = see(patches);
    assert_int_equal(look_down(visibility, 1, 1, 1, true, NULL).patch, 1);
    assert_int_equal(look_down(visibility, 0.25, 1, 1, true, NULL).patch, 0);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void backs_are_culled_or_told(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 4);
    const double wide[3] = {2, 0, 0}, deep[3] = {0, 4, 0};
    set_quad(patches, 0, 0, 0, 0, wide, deep); /* up */
    set_quad(patches, 1, 0, 0, 1, deep, wide); /* down: its back is seen from above */
    set_quad(patches, 2, 0, 0, -1, deep, wide);
    shapes_twin(patches, 2, 3); /* doubleSided, front down */
    hpr_visibility *visibility = see(patches);
    bool back = true;
    hpr_hit hit = look_down(visibility, 0.5, 1, 2, true, &back);
    assert_int_equal(hit.patch, 0);
    assert_false(back);
    assert_true(hit.distance == 2 && hit.s == 0.25 && hit.t == 0.25);
    hit = look_down(visibility, 0.5, 1, 2, false, &back);
    assert_int_equal(hit.patch, 1);
    assert_true(back && hit.distance == 1 && hit.s == 0.25 && hit.t == 0.25);
    for (int cull = 0; cull < 2; cull++) {
        hit = look_down(visibility, 0.5, 3, -0.5, cull, &back);
        assert_int_equal(hit.patch, 3); /* the side that faces up */
        assert_true(!back && hit.distance == 0.5 && hit.s == 0.25 && hit.t == 0.75);
        const double below[3] = {0.5, 3, -3}, upward[3] = {0, 0, 1};
        hit = hpr_visibility_first_hit(visibility, below, upward, 0, INFINITY, cull, &back);
        assert_int_equal(hit.patch, 2);
        assert_true(!back && hit.distance == 2 && hit.s == 0.75 && hit.t == 0.25);
    }
    hit = look_down(visibility, 0.5, 3, -2, true, &back);
    assert_int_equal(hit.patch, HPR_NONE);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void near_and_far_are_open_ends(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 2);
    set_quad(patches, 0, 0, 0, 0, ex, ey);
    set_quad(patches, 1, 0, 0, -1, ex, ey);
    hpr_visibility *visibility = see(patches);
    const double from[3] = {0.5, 0.25, 4}, down[3] = {0, 0, -1}, up[3] = {0, 0, 1}, flat[3] = {1, 0, 0};
    assert_int_equal(hpr_visibility_first_hit(visibility, from, down, 0, 4, true, NULL).patch, HPR_NONE);
    assert_int_equal(hpr_visibility_first_hit(visibility, from, down, 0, 4.0001, true, NULL).patch, 0);
    assert_int_equal(hpr_visibility_first_hit(visibility, from, down, 3.9999, 9, true, NULL).patch, 0);
    assert_int_equal(hpr_visibility_first_hit(visibility, from, down, 4, 9, true, NULL).patch, 1);
    assert_int_equal(hpr_visibility_first_hit(visibility, from, down, 4, 5, true, NULL).patch, HPR_NONE);
    assert_int_equal(hpr_visibility_first_hit(visibility, from, down, 5, 5, true, NULL).patch, HPR_NONE);
    assert_int_equal(hpr_visibility_first_hit(visibility, from, up, 0, 9, true, NULL).patch, HPR_NONE);
    assert_int_equal(hpr_visibility_first_hit(visibility, from, flat, 0, 9, true, NULL).patch, HPR_NONE);
    const double moon[3] = {0.5, 0.25, 4e8};
    hpr_hit hit = hpr_visibility_first_hit(visibility, moon, down, 0, INFINITY, true, NULL);
    assert_int_equal(hit.patch, 0);
    assert_true(hit.s == 0.5 && hit.t == 0.25 && fabs(hit.distance - 4e8) <= 4e8 * 0x1p-52);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* The nearest hit by a loop over all patches, with plain vector algebra of its own. */
static hpr_hit plain_first_hit(const hpr_patches *patches, const double origin[3], const double direction[3],
                               bool cull)
{
    hpr_hit best = {.patch = HPR_NONE, .distance = INFINITY};
    for (size_t i = 0; i < patches->count; i++) {
        double offset[3], point[3], s, t;
        double fall = hpr_dot3(direction, patches->normal + 3 * i);
        if (fall == 0 || (cull && fall > 0))
            continue;
        hpr_subtract3(patches->origin + 3 * i, origin, offset);
        double distance = hpr_dot3(offset, patches->normal + 3 * i) / fall;
        hpr_add_scaled3(origin, distance, direction, point);
        hpr_patch_parameters(patches, i, point, &s, &t);
        bool in = s >= 0 && t >= 0 && (patches->shape[i] ? s + t <= 1 : s <= 1 && t <= 1);
        if (in && distance > 0 && distance < best.distance)
            best = (hpr_hit){(uint32_t)i, s, t, distance};
    }
    return best;
}

static void first_hit_agrees_with_the_plain_loop(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    uint64_t seed = 13;
    size_t hits = 0, total = 0;
    double worst = 0;
    for (int n = 0; n < PLACE_COUNT; n++) {
        const place *p = &places[n];
        hpr_patches *patches = random_scene(ctx, &seed, p);
        hpr_visibility *visibility = see(patches);
        for (int m = 0; m < 10000; m++, total++) {
            double origin[3], direction[3];
            bool cull = m % 2;
            random_point(&seed, m % 3 ? 0 : -2e4, m % 3 ? 1 : 2e4, origin);
            put(p, origin, origin);
            random_direction(&seed, direction);
            if (m % 3 == 0) {
                double target[3];
                random_point(&seed, 0, 1, target);
                put(p, target, target);
                hpr_subtract3(target, origin, direction);
                double length = hpr_length3(direction);
                for (int k = 0; k < 3; k++)
                    direction[k] /= length;
            }
            hpr_hit plain = plain_first_hit(patches, origin, direction, cull);
            hpr_hit tree = hpr_visibility_first_hit(visibility, origin, direction, 0, INFINITY, cull, NULL);
            if (plain.patch != tree.patch)
                fail_msg("place %d, ray %d: loop %u at %g, tree %u at %g", n, m, plain.patch, plain.distance,
                         tree.patch, tree.distance);
            if (plain.patch == HPR_NONE)
                continue;
            hits++;
            double fall = fabs(hpr_dot3(direction, patches->normal + 3 * plain.patch));
            double unit = 0x1p-52 * ((m % 3 ? 1 : 4e4) * p->scale + p->offset) / fall;
            worst = fmax(worst, fabs(plain.distance - tree.distance) / unit);
        }
        hpr_visibility_destroy(&visibility);
        hpr_patches_destroy(&patches);
    }
    assert_true(5 * hits > total && hits < total);
    if (worst > 8) /* roundings of coordinates over the sine; worst seen 0.8 */
        fail_msg("distances differ by %g rounding units", worst);
    hpr_context_destroy(&ctx);
}

/* The hits of one set of rays with a context of its own. */
static void trace_set(int threads, const char *isa, hpr_hit *hit, bool *blocked, int count)
{
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.threads = threads;
    options.isa = isa;
    hpr_context *ctx = NULL;
    assert_int_equal(hpr_context_create(&options, &ctx), HPR_OK);
    uint64_t scene_seed = 17;
    hpr_patches *patches = random_scene(ctx, &scene_seed, &places[1]);
    hpr_visibility *visibility = see(patches);
    uint32_t all[RANDOM_COUNT];
    for (uint32_t i = 0; i < RANDOM_COUNT; i++)
        all[i] = i;
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
    for (int m = 0; m < count; m++) {
        uint64_t seed = (uint64_t)m;
        double origin[3], direction[3], target[3];
        random_point(&seed, 0, 1, origin);
        put(&places[1], origin, origin);
        random_direction(&seed, direction);
        hpr_add_scaled3(origin, 0.5, direction, target);
        hit[m] = hpr_visibility_first_hit(visibility, origin, direction, 0, INFINITY, true, NULL);
        blocked[m] = hpr_visibility_blocked(visibility, origin, target, all, RANDOM_COUNT);
    }
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

static void threads_and_instruction_sets_agree(void **state)
{
    (void)state;
    enum { COUNT = 20000 };
    hpr_hit *hits = calloc(2 * COUNT, sizeof *hits);
    bool *blocked = calloc(2 * COUNT, sizeof *blocked);
    const struct {
        int threads;
        const char *isa;
    } sets[] = {{1, NULL}, {4, NULL}, {1, "sse2"}, {2, "avx2"}};
    for (size_t i = 0; i < sizeof sets / sizeof *sets; i++) {
        size_t to = i ? COUNT : 0;
        memset(hits + to, 0, COUNT * sizeof *hits); /* padding is compared too */
        trace_set(sets[i].threads, sets[i].isa, hits + to, blocked + to, COUNT);
        for (size_t m = 0; m < COUNT; m++) {
            hpr_hit a = hits[m], b = hits[to + m];
            if (a.patch != b.patch || blocked[m] != blocked[to + m] ||
                (a.patch != HPR_NONE && memcmp(&a.s, &b.s, 3 * sizeof(double))))
                fail_msg("set %zu, ray %zu: patch %u and %u", i, m, a.patch, b.patch);
        }
    }
    free(blocked);
    free(hits);
}

static void nothing_to_see(void **state)
{
    (void)state;
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = shapes_create(ctx, 0);
    hpr_visibility *visibility = see(patches);
    assert_int_equal(look_down(visibility, 0, 0, 0, true, NULL).patch, HPR_NONE);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    patches = shapes_create(ctx, 20); /* all without area but the last */
    set_quad(patches, 19, 0, 0, 0, ex, ey);
    visibility = see(patches);
    assert_int_equal(look_down(visibility, 0.5, 0.5, 1, true, NULL).patch, 19);
    uint32_t all[20];
    size_t count;
    for (uint32_t i = 0; i < 20; i++)
        all[i] = i;
    const double x[3] = {0.1, 0.1, 1}, y[3] = {0.1, 0.1, -1};
    assert_int_equal(hpr_visibility_occluder_count(visibility), 1);
    assert_true(hpr_visibility_blocked(visibility, x, y, all, 1));
    assert_false(hpr_visibility_blocked(visibility, x, x, all, 1));
    assert_false(hpr_visibility_blocked(visibility, x, y, all, 0));
    assert_int_equal(classify(visibility, patches, 19, 19, all, &count), HPR_SEES_NOTHING);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

/* Embree's manual asks for flushed denormals; the caller's arithmetic must not notice. */
static void rounding_mode_is_left_alone(void **state)
{
    (void)state;
#if defined(__SSE__)
    unsigned before = _mm_getcsr() & ~0x3fu; /* without the sticky exception flags */
    hpr_context *ctx = shapes_context(1, NULL);
    hpr_patches *patches = turned_room(ctx, &places[0]);
    hpr_visibility *visibility = see(patches);
    look_down(visibility, 0, 0, 0.5, true, NULL);
    assert_int_equal(_mm_getcsr() & ~0x3fu, before);
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
#endif
}

static void memory_may_run_out_anywhere(void **state)
{
    (void)state;
    shapes_allocator allocator = {.fail_at = SIZE_MAX};
    hpr_context *ctx = shapes_context(1, &allocator);
    hpr_patches *patches = turned_room(ctx, &places[0]);
    size_t before = allocator.alive, failures = 0;
    for (size_t k = 0;; k++) {
        hpr_visibility *visibility = NULL;
        allocator.fail_at = allocator.calls + k;
        hpr_status status = hpr_visibility_create(patches, &visibility);
        assert_true((status == HPR_OK) == (visibility != NULL));
        hpr_visibility_destroy(&visibility);
        assert_int_equal(allocator.alive, before);
        if (status == HPR_OK)
            break;
        assert_int_equal(status, HPR_ERR_MEMORY);
        failures++;
    }
    assert_true(failures >= 4); /* itself, faces, fronts, rays; and what merging takes */
    allocator.fail_at = SIZE_MAX;
    hpr_patches_destroy(&patches);
    hpr_context_destroy(&ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rounding_mode_is_left_alone), /* first: modes outlive the test that set them */
        cmocka_unit_test(outermost_corners_are_reached),
        cmocka_unit_test(tree_agrees_with_the_plain_loop),
        cmocka_unit_test(no_leak_between_blockers),
        cmocka_unit_test(no_leak_from_a_room),
        cmocka_unit_test(ties_go_to_the_lowest_index),
        cmocka_unit_test(what_lies_in_one_plane_does_not_flicker),
        cmocka_unit_test(a_sheet_hides_what_it_lies_on),
        cmocka_unit_test(backs_are_culled_or_told),
        cmocka_unit_test(near_and_far_are_open_ends),
        cmocka_unit_test(first_hit_agrees_with_the_plain_loop),
        cmocka_unit_test(threads_and_instruction_sets_agree),
        cmocka_unit_test(nothing_to_see),
        cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
