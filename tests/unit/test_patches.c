/* From faces to patches: welding, merging, what is dropped, two sides. */
#include "failing_allocator.h"
#include "math/vec3.h"
#include "patch/patches.h"
#include "patch/weld.h"

#include <float.h>
#include <string.h>

#define NONE HPR_NONE

typedef struct bench {
    hpr_context *ctx;
    hpr_scene *scene;
    hpr_patches *patches;
} bench;

static int open_bench(void **state)
{
    bench *b = calloc(1, sizeof *b);
    *state = b;
    return !b || hpr_context_create(NULL, &b->ctx) != HPR_OK ||
           hpr_scene_create(b->ctx, "made by hand", 3, NULL, &b->scene) != HPR_OK;
}

static int close_bench(void **state)
{
    bench *b = *state;
    hpr_patches_destroy(&b->patches);
    hpr_scene_destroy(&b->scene);
    hpr_context_destroy(&b->ctx);
    free(b);
    return 0;
}

static uint32_t add_material(bench *b, double rho, bool double_sided)
{
    const double reflectance[3] = {rho, rho / 2, 0}, radiance[3] = {1, 2, 0};
    uint32_t index;
    assert_int_equal(hpr_scene_add_material(b->scene, "paint", reflectance, radiance, double_sided, &index),
                     HPR_OK);
    return index;
}

static void add_mesh(bench *b, hpr_mesh mesh)
{
    assert_int_equal(hpr_scene_add_mesh(b->scene, &mesh), HPR_OK);
}

static const hpr_patches *build(bench *b)
{
    hpr_patches_destroy(&b->patches);
    assert_int_equal(hpr_patches_build(b->scene, &b->patches), HPR_OK);
    return b->patches;
}

/* A mesh of the given node and material over vertices and faces of four indices each. */
#define MESH(of_node, of_material, positions, faces)                                                         \
    (hpr_mesh)                                                                                               \
    {                                                                                                        \
        .node = of_node, .material = of_material, .vertex_count = sizeof(positions) / (3 * sizeof(double)),  \
        .position = &(positions)[0][0], .face_count = sizeof(faces) / (4 * sizeof(uint32_t)),                \
        .vertex = &(faces)[0][0]                                                                             \
    }

static void assert_vector(const double *got, double x, double y, double z, const char *what)
{
    if (!(got[0] == x && got[1] == y && got[2] == z))
        fail_msg("%s is (%.17g, %.17g, %.17g), expected (%.17g, %.17g, %.17g)", what, got[0], got[1], got[2],
                 x, y, z);
}

static void assert_frame(const hpr_patches *p, size_t i, const double *origin, const double *first,
                         const double *last)
{
    assert_vector(p->origin + 3 * i, origin[0], origin[1], origin[2], "origin");
    assert_vector(p->edge1 + 3 * i, first[0] - origin[0], first[1] - origin[1], first[2] - origin[2],
                  "edge1");
    assert_vector(p->edge2 + 3 * i, last[0] - origin[0], last[1] - origin[1], last[2] - origin[2], "edge2");
}

static const double square[4][3] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};

/* Vertex 0 is the first triangle's first vertex, then counter-clockwise, whichever edge is shared and however
 * the second triangle is turned. */
static void merging_starts_at_the_first_triangle(void **state)
{
    bench *b = *state;
    static const uint32_t first[3][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}};
    static const uint32_t second[3][3] = {{0, 2, 3}, {2, 3, 0}, {3, 0, 2}};
    size_t n = 0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++, n++) {
            const uint32_t faces[2][4] = {{first[i][0], first[i][1], first[i][2], NONE},
                                          {second[j][0], second[j][1], second[j][2], NONE}};
            double shifted[4][3]; /* apart from the others */
            memcpy(shifted, square, sizeof square);
            for (int k = 0; k < 4; k++)
                shifted[k][2] = (double)n;
            add_mesh(b, MESH((uint32_t)n, NONE, shifted, faces));
        }
    }
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 9);
    for (size_t i = 0; i < 9; i++) {
        double corner[4][3];
        memcpy(corner, square, sizeof square);
        for (int k = 0; k < 4; k++)
            corner[k][2] = (double)i;
        size_t v0 = first[i / 3][0];
        assert_int_equal(p->shape[i], HPR_SHAPE_PARALLELOGRAM);
        assert_frame(p, i, corner[v0], corner[(v0 + 1) % 4], corner[(v0 + 3) % 4]);
        assert_vector(p->normal + 3 * i, 0, 0, 1, "normal");
        assert_true(p->area_m2[i] == 2);
        assert_int_equal(p->node[i], i);
    }
}

/* In a strip of equal triangles each could go with either neighbour. */
static void lowest_index_merges_first(void **state)
{
    bench *b = *state;
    const double strip[5][3] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {1.5, 1, 0}, {2, 0, 0}};
    const uint32_t forward[3][4] = {{0, 1, 2, NONE}, {1, 3, 2, NONE}, {1, 4, 3, NONE}};
    const uint32_t middle_first[3][4] = {{1, 3, 2, NONE}, {1, 4, 3, NONE}, {0, 1, 2, NONE}};
    add_mesh(b, MESH(0, NONE, strip, forward));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 2);
    assert_int_equal(p->shape[0], HPR_SHAPE_PARALLELOGRAM);
    assert_frame(p, 0, strip[0], strip[1], strip[2]);
    assert_int_equal(p->shape[1], HPR_SHAPE_TRIANGLE);
    assert_frame(p, 1, strip[1], strip[4], strip[3]);
    hpr_scene_destroy(&b->scene);
    hpr_patches_destroy(&b->patches);
    assert_int_equal(hpr_scene_create(b->ctx, "again", 3, NULL, &b->scene), HPR_OK);
    add_mesh(b, MESH(0, NONE, strip, middle_first));
    p = build(b);
    assert_int_equal(p->count, 2);
    assert_frame(p, 0, strip[1], strip[4], strip[2]); /* with face 1, not with face 2 */
    assert_int_equal(p->shape[1], HPR_SHAPE_TRIANGLE);
}

/* Adds the square as two triangles with these attributes and returns how many patches come of it. */
static size_t patches_of_pair(bench *b, const double (*position)[3], const double *uv, const double *colour)
{
    static const uint32_t faces[2][4] = {{0, 1, 2, NONE}, {0, 2, 3, NONE}};
    hpr_scene_destroy(&b->scene);
    hpr_patches_destroy(&b->patches);
    assert_int_equal(hpr_scene_create(b->ctx, "pair", 3, NULL, &b->scene), HPR_OK);
    hpr_mesh mesh = {.material = NONE,
                     .vertex_count = 4,
                     .position = position[0],
                     .uv = uv,
                     .colour = colour,
                     .face_count = 2,
                     .vertex = faces[0]};
    add_mesh(b, mesh);
    return build(b)->count;
}

static void attributes_must_be_affine(void **state)
{
    bench *b = *state;
    const double plain[4][2] = {{0, 0}, {5, 1}, {5, 3}, {0, 2}},
                 bent[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0.9}};
    const double missing[4][2] = {{0, 0}, {1, 0}, {1, 1}, {NAN, NAN}};
    const double shade[4][3] = {{0.1, 0, 0}, {0.3, 0, 0}, {0.5, 0, 0}, {0.3, 0, 0}};
    const double spot[4][3] = {{0.1, 0, 0}, {0.3, 0, 0}, {0.4, 0, 0}, {0.3, 0, 0}};
    double rounded[4][2] = {{0, 0}, {0.1f, 0}, {0.1f, 0.3f}, {0, 0.3f}};
    rounded[2][0] += 1e-7;
    assert_int_equal(patches_of_pair(b, square, NULL, NULL), 1);
    assert_int_equal(patches_of_pair(b, square, plain[0], NULL), 1);
    assert_int_equal(patches_of_pair(b, square, rounded[0], NULL), 1);
    assert_int_equal(patches_of_pair(b, square, bent[0], NULL), 2);
    assert_int_equal(patches_of_pair(b, square, missing[0], NULL), 2);
    assert_int_equal(patches_of_pair(b, square, NULL, shade[0]), 1);
    assert_int_equal(patches_of_pair(b, square, NULL, spot[0]), 2);
}

static void only_flat_convex_pairs_merge(void **state)
{
    bench *b = *state;
    const double bent[4][3] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0.001}};
    const double bent_trapezoid[4][3] = {{0, 0, 0}, {2, 0, 0}, {1.9, 1, 0}, {0, 1, 0.001}};
    const double dart[4][3] = {{0, 0, 0}, {2, 1, 0}, {0.5, 0.5, 0}, {1, 2, 0}};
    const double straight[4][3] = {{0, 0, 0}, {2, 0, 0}, {1.01, 1, 0}, {0, 2, 0}};
    const double trapezoid[4][3] = {{0, 0, 0}, {2, 0, 0}, {1.9, 1, 0}, {0, 1, 0}};
    const double rounded[4][3] = {{0, 0, 0}, {2, 0, 0}, {2.0000002, 1, 0}, {0, 1, 2e-7}};
    const double skewed[4][3] = {{0, 0, 0}, {2, 0, 1}, {3, 1, 1.5}, {1, 1, 0.5}};
    assert_int_equal(patches_of_pair(b, bent, NULL, NULL), 2);
    assert_int_equal(patches_of_pair(b, bent_trapezoid, NULL, NULL), 2);
    assert_int_equal(patches_of_pair(b, dart, NULL, NULL), 2);
    assert_int_equal(patches_of_pair(b, straight, NULL, NULL), 2);
    assert_int_equal(patches_of_pair(b, trapezoid, NULL, NULL), 1);
    assert_int_equal(patches_of_pair(b, rounded, NULL, NULL), 1);
    assert_int_equal(patches_of_pair(b, skewed, NULL, NULL), 1);
}

/* From the first triangle's first vertex counter-clockwise, on the back the other way round. */
static void quadrilaterals_have_an_opposite_corner(void **state)
{
    bench *b = *state;
    const double skew[4][3] = {{1, 0, 3}, {3, 0, 3}, {2.5, 1, 3}, {1, 2, 3}};
    const uint32_t faces[2][4] = {{2, 3, 1, NONE}, {0, 1, 3, NONE}};
    uint32_t both = add_material(b, 0.5, true);
    add_mesh(b, MESH(0, both, skew, faces));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 2);
    assert_int_equal(p->shape[0], HPR_SHAPE_QUADRILATERAL);
    assert_int_equal(p->shape[1], HPR_SHAPE_QUADRILATERAL);
    assert_frame(p, 0, skew[2], skew[3], skew[1]);
    assert_frame(p, 1, skew[2], skew[1], skew[3]);
    assert_true(p->opposite[0] == p->opposite[3] && p->opposite[1] == p->opposite[2]);
    for (size_t i = 0; i < 2; i++) {
        double corner[4][3], gap[3];
        assert_int_equal(hpr_patch_corners(p, i, corner), 4);
        hpr_subtract3(corner[2], skew[0], gap);
        /* a sum of three products of numbers up to 3, and their parameters */
        assert_true(hpr_length3(gap) <= 32 * DBL_EPSILON);
        assert_true(fabs(p->area_m2[i] - 2.5) <= 16 * DBL_EPSILON);
    }
}

/* A triangle that could go with two others goes where it makes a parallelogram. */
static void parallelograms_come_first(void **state)
{
    bench *b = *state;
    const double strip[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {-0.5, 0.75, 0}};
    const uint32_t faces[3][4] = {{0, 2, 4, NONE}, {0, 1, 2, NONE}, {1, 3, 2, NONE}};
    add_mesh(b, MESH(0, NONE, strip, faces));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 2);
    assert_int_equal(p->shape[0], HPR_SHAPE_TRIANGLE);
    assert_int_equal(p->shape[1], HPR_SHAPE_PARALLELOGRAM);
}

/* View factors have a row for each triangle as ever. */
static void factors_know_no_quadrilaterals(void **state)
{
    bench *b = *state;
    const double skew[4][3] = {{0, 0, 0}, {2, 0, 0}, {1.5, 1, 0}, {0, 2, 0}};
    const uint32_t faces[2][4] = {{0, 1, 2, NONE}, {0, 2, 3, NONE}};
    add_mesh(b, MESH(0, NONE, skew, faces));
    assert_int_equal(hpr_patches_build_all(b->scene, &b->patches), HPR_OK);
    assert_int_equal(b->patches->shape[0], HPR_SHAPE_TRIANGLE);
    assert_int_equal(b->patches->shape[1], HPR_SHAPE_TRIANGLE);
}

static void opposite_winding_does_not_merge(void **state)
{
    bench *b = *state;
    const uint32_t faces[2][4] = {{0, 1, 2, NONE}, {0, 3, 2, NONE}};
    add_mesh(b, MESH(0, NONE, square, faces));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 2);
    assert_vector(p->normal, 0, 0, 1, "normal");
    assert_vector(p->normal + 3, 0, 0, -1, "normal");
}

static void meshes_do_not_merge(void **state)
{
    bench *b = *state;
    const uint32_t low[1][4] = {{0, 1, 2, NONE}}, high[1][4] = {{0, 2, 3, NONE}};
    uint32_t red = add_material(b, 0.5, false), green = add_material(b, 0.4, false);
    double lifted[4][3];
    memcpy(lifted, square, sizeof square);
    add_mesh(b, MESH(0, red, lifted, low));
    add_mesh(b, MESH(0, green, lifted, high)); /* another material */
    for (int k = 0; k < 4; k++)
        lifted[k][2] = 1;
    add_mesh(b, MESH(1, red, lifted, low));
    add_mesh(b, MESH(2, red, lifted, high)); /* another node */
    for (int k = 0; k < 4; k++)
        lifted[k][2] = 2;
    add_mesh(b, MESH(3, red, lifted, low));
    hpr_mesh primitive = MESH(3, red, lifted, high);
    primitive.primitive = 1;
    add_mesh(b, primitive);
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 6);
    assert_int_equal(p->material[1], green);
    assert_int_equal(p->node[3], 2);
    assert_int_equal(p->primitive[5], 1);
    assert_int_equal(p->degenerate_count + p->duplicate_count, 0);
}

/* Two unit squares side by side, the second `gap` off in x, y and z; returns whether they share vertices. */
static bool touch_after_welding(bench *b, double gap, double scale, double offset)
{
    const uint32_t faces[1][4] = {{0, 1, 2, 3}};
    double left[4][3] = {{0, 0, 0}, {0.5, 0, 0}, {0.5, 1, 0}, {0, 1, 0}};
    double right[4][3] = {{0.5, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.5, 1, 0}};
    for (int k = 0; k < 4; k++) {
        for (int a = 0; a < 3; a++) {
            left[k][a] = scale * (left[k][a] + offset);
            right[k][a] = scale * (right[k][a] + gap / sqrt(3) + offset);
        }
    }
    hpr_scene_destroy(&b->scene);
    hpr_patches_destroy(&b->patches);
    assert_int_equal(hpr_scene_create(b->ctx, "gap", 3, NULL, &b->scene), HPR_OK);
    add_mesh(b, MESH(0, NONE, left, faces));
    add_mesh(b, MESH(1, NONE, right, faces));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 2);
    bool same = memcmp(p->origin + 3, left[1], sizeof left[1]) == 0;
    assert_true(same || memcmp(p->origin + 3, right[0], sizeof right[0]) == 0);
    return same;
}

/* 4 float32 ulp of the size: 4.8e-7 of it. */
static void welding_closes_gaps_of_rounding_only(void **state)
{
    bench *b = *state;
    static const double scale[] = {1, 1e-3, 1e4}, offset[] = {0, -0.5, 0.3, -1000};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            assert_true(touch_after_welding(b, 1e-8, scale[i], offset[j]));
            assert_true(touch_after_welding(b, -1e-8, scale[i], offset[j]));
            assert_true(touch_after_welding(b, 4e-7, scale[i], offset[j]));
            assert_false(touch_after_welding(b, 6e-7, scale[i], offset[j]));
            assert_false(touch_after_welding(b, 1e-5, scale[i], offset[j]));
        }
    }
    touch_after_welding(b, 0, 1, 0);
    assert_true(b->patches->weld_m == 4 * 0x1p-23);
    assert_true(hpr_weld_distance((double[]){0, 0, 0}, (double[]){3, 1, 8}) == 32 * 0x1p-23);
    assert_true(hpr_weld_distance((double[]){1, 1, 1}, (double[]){1, 1, 1}) == 0);
}

/* Triangles that share no vertex by index, only by place, make a parallelogram too. */
static void welding_comes_before_merging(void **state)
{
    bench *b = *state;
    const double soup[6][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1e-8, 0, 1e-8}, {1, 1 + 1e-8, 0}, {0, 1, 0}};
    const uint32_t faces[2][4] = {{0, 1, 2, NONE}, {3, 4, 5, NONE}};
    add_mesh(b, MESH(0, NONE, soup, faces));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 1);
    assert_frame(p, 0, soup[0], soup[1], soup[5]);
}

/* A shared vertex has the same bits wherever it is an origin, and the corners that follow from origin and
 * edges agree with it to a rounding. */
static void neighbours_share_vertices(void **state)
{
    bench *b = *state;
    const double centre[3] = {0.1, 0.7, -1.3}, noise = 3e-8;
    double ring[7][3] = {{0}};
    uint32_t faces[6][4];
    memcpy(ring[6], centre, sizeof centre);
    for (uint32_t k = 0; k < 6; k++) {
        ring[k][0] = 0.1 + 0.37 * cos(k);
        ring[k][1] = 0.7 + 0.41 * sin(k);
        ring[k][2] = -1.3 + 0.013 * k * k;
    }
    for (uint32_t k = 0; k < 6; k++) {
        const double fan[3][3] = {{centre[0] + noise * cos(5 * k), centre[1], centre[2] - noise * sin(3 * k)},
                                  {ring[k][0], ring[k][1] + noise * cos(k), ring[k][2]},
                                  {ring[(k + 1) % 6][0], ring[(k + 1) % 6][1], ring[(k + 1) % 6][2] + noise}};
        const uint32_t face[1][4] = {{k % 3, (k + 1) % 3, (k + 2) % 3, NONE}};
        memcpy(faces[k], face[0], sizeof face[0]);
        add_mesh(b, MESH(k, NONE, fan, face));
    }
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 6);
    double worst = 0;
    for (size_t i = 0; i < 6; i++) {
        double corner[4][3];
        hpr_patch_corners(p, i, corner);
        /* fan vertex 0 is corner (3 - i % 3) % 3 of patch i */
        for (int a = 0; a < 3; a++)
            worst = fmax(worst, fabs(corner[(3 - i % 3) % 3][a] - p->origin[a]));
        if (i % 3 == 0)
            assert_memory_equal(p->origin + 3 * i, p->origin, 3 * sizeof(double));
    }
    /* origin + (vertex - origin) rounds twice */
    print_message("one vertex of six patches: corners differ by %.1e, bound %.1e\n", worst,
                  2 * 1.3 * DBL_EPSILON);
    assert_true(worst <= 2 * 1.3 * DBL_EPSILON);
}

static void faces_without_area_are_dropped(void **state)
{
    bench *b = *state;
    const double v[7][3] = {{0, 0, 0},     {1, 0, 0},    {0, 1, 0}, {2, 0, 0},
                            {1, 1e-13, 0}, {1e-9, 0, 0}, {3, 0, 0}};
    const uint32_t faces[][4] = {
        {0, 1, 1, NONE},               /* two corners are one */
        {0, 1, 3, NONE},               /* in a line */
        {0, 3, 4, NONE},               /* in a line but for rounding */
        {0, 1, 2, NONE},               /* good */
        {0, 5, 2, NONE},               /* two corners become one */
        {0, 0, 0, NONE}, {0, 1, 2, 2}, /* a quad with one good half */
        {0, 0, 1, 1},                  /* quads that would be parallelograms but for their area */
        {0, 1, 6, 3},    {3, 3, 3, 3},
    };
    add_mesh(b, MESH(0, NONE, v, faces));
    const hpr_patches *p = build(b);
    for (size_t i = 0; i < p->count; i++) {
        double length = hpr_length3(p->normal + 3 * i);
        if (!(p->area_m2[i] > 1e-9 && fabs(length - 1) < 1e-15))
            fail_msg("patch %zu has area %g and a normal of length %g", i, p->area_m2[i], length);
    }
    /* The good half of the quad is the good triangle again. */
    assert_int_equal(p->count, 1);
    assert_int_equal(p->duplicate_count, 1);
    assert_int_equal(p->degenerate_count, 5 + 3); /* triangles and whole quads */
    assert_true(hpr_warning_count(b->ctx) == 2);
}

static void quads_stay_whole_or_fall_in_two(void **state)
{
    bench *b = *state;
    const double v[5][3] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}, {1.5, 1, 0}};
    const uint32_t whole[1][4] = {{1, 2, 3, 0}}, halved[1][4] = {{0, 1, 4, 3}};
    double up[5][3];
    memcpy(up, v, sizeof v);
    for (int k = 0; k < 5; k++)
        up[k][2] = k == 3 ? 1.5 : 1;
    add_mesh(b, MESH(0, NONE, v, whole));
    add_mesh(b, MESH(0, NONE, up, halved)); /* not flat */
    add_mesh(b, MESH(0, NONE, v, halved));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 4);
    assert_int_equal(p->shape[0], HPR_SHAPE_PARALLELOGRAM);
    assert_frame(p, 0, v[1], v[2], v[0]);
    assert_int_equal(p->shape[1], HPR_SHAPE_TRIANGLE);
    assert_frame(p, 1, up[0], up[1], up[4]);
    assert_frame(p, 2, up[0], up[4], up[3]);
    assert_int_equal(p->shape[3], HPR_SHAPE_QUADRILATERAL);
    assert_frame(p, 3, v[0], v[1], v[3]);
    assert_true(p->opposite[6] == 0.75 && p->opposite[7] == 1 && p->area_m2[3] == 1.75);
}

static void two_sides_are_twins(void **state)
{
    bench *b = *state;
    const uint32_t faces[1][4] = {{0, 1, 2, 3}}, corner[1][4] = {{0, 1, 2, NONE}};
    double up[4][3];
    memcpy(up, square, sizeof square);
    for (int k = 0; k < 4; k++)
        up[k][2] = 1;
    uint32_t both = add_material(b, 0.6, true), one = add_material(b, 0.6, false);
    add_mesh(b, MESH(0, one, square, faces));
    add_mesh(b, MESH(1, both, up, corner));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 3);
    assert_true(p->twin[0] == NONE && p->twin[1] == 2 && p->twin[2] == 1);
    assert_true(p->side[0] == 0 && p->side[1] == 0 && p->side[2] == 1);
    assert_frame(p, 1, up[0], up[1], up[2]);
    assert_frame(p, 2, up[0], up[2], up[1]);
    assert_vector(p->normal + 3, 0, 0, 1, "front");
    assert_vector(p->normal + 6, 0, 0, -1, "back");
    assert_true(p->area_m2[1] == 1 && p->area_m2[2] == 1);
    assert_memory_equal(p->reflectance + 3, p->reflectance + 6, 3 * sizeof(double));
    assert_memory_equal(p->exitance + 3, p->exitance + 6, 3 * sizeof(double));
}

static void optics_come_from_material_and_faces(void **state)
{
    bench *b = *state;
    const uint32_t faces[2][4] = {{0, 1, 2, NONE}, {0, 2, 3, NONE}};
    const double mean[2][3] = {{0.2, 0.4, 0.6}, {0.4, 0.5, 0}}, pi = 3.14159265358979323846;
    uint32_t paint = add_material(b, 0.5, false);
    hpr_mesh mesh = MESH(7, paint, square, faces);
    mesh.face_reflectance = mean[0];
    mesh.primitive = 3;
    add_mesh(b, mesh);
    double up[4][3];
    memcpy(up, square, sizeof square);
    for (int k = 0; k < 4; k++)
        up[k][2] = 1;
    add_mesh(b, MESH(8, NONE, up, faces));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 2);
    for (int c = 0; c < 3; c++) {
        /* halves of equal area */
        assert_true(fabs(p->reflectance[c] - (mean[0][c] + mean[1][c]) / 2) <= DBL_EPSILON);
        assert_true(p->exitance[c] == pi * (c == 2 ? 0 : c + 1));
        assert_true(p->reflectance[3 + c] == 0.8 && p->exitance[3 + c] == 0);
    }
    assert_true(p->node[0] == 7 && p->primitive[0] == 3 && p->material[0] == paint && p->material[1] == NONE);
}

/* Adds the square as a quad that starts at corner `turn`, facing up or down. */
static void add_square(bench *b, uint32_t node, uint32_t material, uint32_t turn, bool down)
{
    uint32_t face[1][4];
    for (uint32_t k = 0; k < 4; k++)
        face[0][k] = (turn + (down ? 4 - k : k)) % 4;
    add_mesh(b, MESH(node, material, square, face));
}

static void equal_patches_count_once_per_side(void **state)
{
    bench *b = *state;
    uint32_t one = add_material(b, 0.5, false), both = add_material(b, 0.6, true);
    add_square(b, 0, one, 0, false);  /* stays */
    add_square(b, 1, both, 1, false); /* its front is there already, its back is new */
    add_square(b, 2, one, 3, true);   /* faces like that back */
    add_square(b, 3, both, 2, true);  /* both sides are there */
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 2);
    assert_int_equal(p->duplicate_count, 4);
    assert_true(p->node[0] == 0 && p->side[0] == 0 && p->node[1] == 1 && p->side[1] == 1);
    assert_true(p->twin[0] == NONE && p->twin[1] == NONE);
    assert_vector(p->normal, 0, 0, 1, "first");
    assert_vector(p->normal + 3, 0, 0, -1, "second");
}

static void back_to_back_patches_are_no_duplicates(void **state)
{
    bench *b = *state;
    const uint32_t other[1][4] = {{0, 1, 3, NONE}}; /* overlaps, but is not equal */
    add_square(b, 0, NONE, 0, false);
    add_square(b, 1, NONE, 0, true);
    add_mesh(b, MESH(2, NONE, square, other));
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 3);
    assert_int_equal(p->duplicate_count, 0);
}

static void nothing_gives_nothing(void **state)
{
    bench *b = *state;
    const hpr_patches *p = build(b);
    assert_int_equal(p->count, 0);
    assert_true(p->weld_m == 0);
}

static hpr_status build_and_destroy(hpr_context *ctx, void *data)
{
    const uint32_t faces[3][4] = {{0, 1, 2, NONE}, {0, 2, 3, NONE}, {0, 1, 4, NONE}};
    const double v[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0, 1}};
    const double grey[3] = {0.5, 0.5, 0.5}, dark[3] = {0, 0, 0};
    hpr_scene *scene = NULL;
    hpr_patches *patches = NULL;
    uint32_t material;
    (void)data;
    hpr_status status = hpr_scene_create(ctx, "sweep", 3, NULL, &scene);
    if (status == HPR_OK)
        status = hpr_scene_add_material(scene, "paint", grey, dark, true, &material);
    if (status == HPR_OK) {
        hpr_mesh mesh = MESH(0, material, v, faces);
        status = hpr_scene_add_mesh(scene, &mesh);
    }
    if (status == HPR_OK)
        status = hpr_patches_build(scene, &patches);
    assert_true(status != HPR_OK ? patches == NULL : patches->count == 4);
    hpr_patches_destroy(&patches);
    hpr_scene_destroy(&scene);
    return status;
}

static void no_memory(void **state)
{
    (void)state;
    size_t allocations = sweep_allocations(build_and_destroy, NULL, 1);
    print_message("%zu allocations, each failed once\n", allocations);
    assert_true(allocations > 20);
}

#define FACT(test) cmocka_unit_test_setup_teardown(test, open_bench, close_bench)

int main(void)
{
    const struct CMUnitTest tests[] = {
        FACT(merging_starts_at_the_first_triangle),
        FACT(lowest_index_merges_first),
        FACT(attributes_must_be_affine),
        FACT(only_flat_convex_pairs_merge),
        FACT(opposite_winding_does_not_merge),
        FACT(quadrilaterals_have_an_opposite_corner),
        FACT(parallelograms_come_first),
        FACT(factors_know_no_quadrilaterals),
        FACT(meshes_do_not_merge),
        FACT(welding_closes_gaps_of_rounding_only),
        FACT(welding_comes_before_merging),
        FACT(neighbours_share_vertices),
        FACT(faces_without_area_are_dropped),
        FACT(quads_stay_whole_or_fall_in_two),
        FACT(two_sides_are_twins),
        FACT(optics_come_from_material_and_faces),
        FACT(equal_patches_count_once_per_side),
        FACT(back_to_back_patches_are_no_duplicates),
        FACT(nothing_gives_nothing),
        cmocka_unit_test(no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
