/*
 * Pairs of patches on which quadrature breaks, one table: what is reachable and what is reached, as Markdown
 * on stdout. Exit code 1 if a case misses its bound. hard_cases [--details]
 */
#include "blocks.h"
#include "contour.h"
#include "open_cases.h"

#include "patch/patches.h"

#include <time.h>

#define PI 3.14159265358979323846

enum { DEGREE_MAX = 8, VALUES_MAX = HPR_MAX_BASIS * HPR_MAX_BASIS };

/* Demanded of every block; what is asked of it then: the digits of a reference, but at most twelve. */
static const double demanded = 1e-13, best = 1e-12;

/* Where only bits are compared. */
static const double rough = 1e-6;

static double block_a[VALUES_MAX], block_b[VALUES_MAX];

/* What a case comes to; error is relative, of a block to its largest entry. */
typedef struct outcome {
    double value; /* F12, NAN if the case has no single one */
    double error;
    bool short_of; /* a block stopped short of what was demanded */
} outcome;

/* Corners of both patches; what F12 is known from. */
typedef struct pair {
    int count1, count2;
    double corner1[4][3], corner2[4][3];
} pair;

typedef struct hard_case {
    const char *name, *known; /* known from */
    int digits;               /* trusted of the reference */
    outcome (*measure)(const struct hard_case *it);
    const char *id; /* of the open set */
    double expected, number;
    pair pair;
} hard_case;

static outcome factor_of(const pair *p, double expected)
{
    hpr_element_frame one = frame_of_corners(0, p->count1, p->corner1);
    hpr_element_frame two = frame_of_corners(0, p->count2, p->corner2);
    double block;
    hpr_block_result result = block_of(&one, &two, demanded, &block);
    double factor = block * sqrt(two.area_m2 / one.area_m2);
    return (outcome){.value = expected,
                     .error = expected != 0 ? fabs(factor / expected - 1) : fabs(factor),
                     .short_of = result.status >= HPR_BLOCK_SHORT};
}

static outcome open_case(const hard_case *it)
{
    for (int i = 0; i < OPEN_FACTORS; i++) {
        const open_factor *c = &open_factors[i];
        if (strcmp(c->id, it->id) == 0) {
            pair p = {.count1 = c->count1, .count2 = c->count2};
            memcpy(p.corner1, c->corner1, sizeof p.corner1);
            memcpy(p.corner2, c->corner2, sizeof p.corner2);
            return factor_of(&p, c->value);
        }
    }
    return (outcome){.error = INFINITY};
}

static outcome stated_case(const hard_case *it)
{
    return factor_of(&it->pair, it->expected);
}

static outcome contour_case(const hard_case *it)
{
    const pair *p = &it->pair;
    hpr_element_frame one = frame_of_corners(0, p->count1, p->corner1);
    return factor_of(p, contour_exchange(p->count1, p->corner1, p->count2, p->corner2) / one.area_m2);
}

/* Unit squares sharing an edge, opened by `number` degrees. */
static outcome opened_case(const hard_case *it)
{
    double angle = it->number * PI / 180, c = cos(angle), s = sin(angle);
    hard_case opened = {.pair = {.count1 = 4,
                                 .count2 = 4,
                                 .corner1 = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                                 .corner2 = {{0, 0, 0}, {0, 1, 0}, {c, 1, s}, {c, 0, s}}}};
    return contour_case(&opened);
}

static pair squares_at(double x, double y, double z)
{
    return (pair){.count1 = 4,
                  .count2 = 4,
                  .corner1 = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                  .corner2 = {{x, y, z}, {x, y + 1, z}, {x + 1, y + 1, z}, {x + 1, y, z}}};
}

/* Unit squares face to face at distance `number`. */
static outcome gap_case(const hard_case *it)
{
    pair p = squares_at(0, 0, it->number);
    const double unit[2] = {0, 1};
    return factor_of(&p, exchange_parallel(unit, unit, unit, unit, it->number));
}

/* A unit wall that starts `number` above the edge of the unit floor. */
static outcome lifted_case(const hard_case *it)
{
    double u = it->number;
    const double unit[2] = {0, 1}, up[2] = {u, u + 1};
    pair p = {.count1 = 4,
              .count2 = 4,
              .corner1 = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
              .corner2 = {{0, 0, u}, {0, 1, u}, {0, 1, u + 1}, {0, 0, u + 1}}};
    return factor_of(&p, exchange_perpendicular(unit, unit, up, unit));
}

/*
 * Unit squares face to face, the other moved by (number, 0, number): with x = number + a, y = b (a, b the
 * differences of the points, of mean 0 and variance 1/6) the kernel h^2 / (pi (h^2 + x^2 + y^2)^2) is
 * averaged over a Taylor series; the fourth moments drop out at 1e-16.
 */
static outcome far_case(const hard_case *it)
{
    double h = it->number, q = 1 / (h * h), kernel = h * h / (PI * 4 * h * h * h * h);
    /* d2/dx2 of (h^2 + x^2)^-2 at x = h, over itself: (-4 r^2 + 24 x^2) / r^4 = 4 / h^2; d2/dy2: -4 / r^2 */
    double factor = kernel * (1 + (4 * q - 2 * q) / 12);
    pair p = squares_at(h, 0, h);
    return factor_of(&p, factor);
}

/* The same face to face: (1 + (x^2 + y^2) / h^2)^-2 = 1 - 2/3 / h^2 + ... */
static outcome far_facing_case(const hard_case *it)
{
    double h = it->number;
    pair p = squares_at(0, 0, h);
    return factor_of(&p, (1 - 2 / (3 * h * h)) / (PI * h * h));
}

static hpr_element_frame floor_of(double x0, double x1, double y0, double y1)
{
    return frame_of(HPR_SHAPE_PARALLELOGRAM, 0, (double[]){x0, y0, 0}, (double[]){x1, y0, 0},
                    (double[]){x0, y1, 0});
}

static hpr_element_frame wall_of(double x, double y0, double y1, double z0, double z1)
{
    return frame_of(HPR_SHAPE_PARALLELOGRAM, 0, (double[]){x, y0, z0}, (double[]){x, y1, z0},
                    (double[]){x, y0, z1});
}

static outcome exchange_error(const hpr_element_frame *a, const hpr_element_frame *b, double exact)
{
    double block;
    hpr_block_result result = block_of(a, b, demanded, &block);
    return (outcome){.value = exact / a->area_m2,
                     .error = fabs(block * sqrt(a->area_m2 * b->area_m2) / exact - 1),
                     .short_of = result.status >= HPR_BLOCK_SHORT};
}

/* A wall of height `number` stands on the middle of a floor. */
static outcome standing_case(const hard_case *it)
{
    double h = it->number;
    hpr_element_frame ground = floor_of(-1, 1, -1, 1), wall = wall_of(0, -0.25, 0.5, 0, h);
    return exchange_error(&wall, &ground,
                          exchange_perpendicular((double[]){0, 1}, (double[]){-1, 1}, (double[]){0, h},
                                                 (double[]){-0.25, 0.5}));
}

/* The foot of a wall is `number` of the edge it stands on. */
static outcome short_foot_case(const hard_case *it)
{
    const double unit[2] = {0, 1}, foot[2] = {0.5, 0.5 + it->number};
    hpr_element_frame ground = floor_of(0, 1, 0, 1), wall = wall_of(0, foot[0], foot[1], 0, 1);
    return exchange_error(&wall, &ground, exchange_perpendicular(unit, unit, unit, foot));
}

/* A wall goes through a floor and `number` below it. */
static outcome piercing_case(const hard_case *it)
{
    hpr_element_frame ground = floor_of(0, 1, 0, 1), wall = wall_of(0.25, 0.25, 0.75, -it->number, 1);
    return exchange_error(&wall, &ground,
                          exchange_perpendicular((double[]){0, 0.75}, (double[]){0, 1}, (double[]){0, 1},
                                                 (double[]){0.25, 0.75}));
}

/* Moved by 2^20 along x, y and z, where a coordinate that is a multiple of 2^-32 is exact. */
static outcome moved_case(const hard_case *it)
{
    pair p = it->pair;
    hpr_element_frame one = frame_of_corners(0, p.count1, (const double(*)[3])p.corner1);
    double exact =
        contour_exchange(p.count1, (const double(*)[3])p.corner1, p.count2, (const double(*)[3])p.corner2) /
        one.area_m2;
    for (int i = 0; i < 12; i++) {
        p.corner1[i / 3][i % 3] += 0x1p20;
        p.corner2[i / 3][i % 3] += 0x1p20;
    }
    return factor_of(&p, exact);
}

static hpr_element_frame scaled(const double (*corner)[3], double scale, int degree)
{
    double c[4][3];
    for (int i = 0; i < 12; i++)
        c[i / 3][i % 3] = scale * corner[i / 3][i % 3];
    return frame_of_corners(degree, 4, (const double(*)[3])c);
}

/* Scaled by powers of two: the same bits. The error counts entries that differ. */
static outcome bits_case(const hard_case *it)
{
    static const int power[] = {-100, -30, 1, 40, 100};
    outcome out = {.value = NAN};
    for (size_t k = 0; k < sizeof power / sizeof *power; k++) {
        double scale = ldexp(1, power[k]);
        hpr_element_frame a = scaled(it->pair.corner1, 1, 2), b = scaled(it->pair.corner2, 1, 2);
        hpr_element_frame c = scaled(it->pair.corner1, scale, 2), d = scaled(it->pair.corner2, scale, 2);
        out.short_of |= block_of(&a, &b, rough, block_a).status >= HPR_BLOCK_SHORT;
        block_of(&c, &d, rough, block_b);
        for (size_t i = 0; i < frame_basis(&a) * frame_basis(&b); i++)
            out.error += block_a[i] != block_b[i];
    }
    return out;
}

/* Both ways round, degrees 1 to 8: integrals of their own, for the sides change roles. */
static outcome reciprocity_case(const hard_case *it)
{
    const pair *p = &it->pair;
    outcome out = {.value = NAN};
    for (int degree = 1; degree <= DEGREE_MAX; degree++) {
        hpr_element_frame a = frame_of_corners(degree, p->count1, p->corner1);
        hpr_element_frame b = frame_of_corners(degree, p->count2, p->corner2);
        size_t na = frame_basis(&a), nb = frame_basis(&b);
        out.short_of |= block_of(&a, &b, demanded, block_a).status >= HPR_BLOCK_SHORT;
        out.short_of |= block_of(&b, &a, demanded, block_b).status >= HPR_BLOCK_SHORT;
        double largest = largest_entry(block_a, na * nb);
        for (size_t i = 0; i < na * nb; i++)
            out.error = fmax(out.error, fabs(block_a[i] - block_b[i % nb * na + i / nb]) / largest);
    }
    return out;
}

/* The box of height `number` over the unit square: the floor's moments of the kernel, degrees 1 to 8, over
 * all other faces sum to those of 1. */
static outcome closure_case(const hard_case *it)
{
    double h = it->number;
    const double face[5][4][3] = {{{0, 0, 0}, {0, 1, 0}, {0, 1, h}, {0, 0, h}},
                                  {{1, 0, 0}, {1, 0, h}, {1, 1, h}, {1, 1, 0}},
                                  {{0, 0, 0}, {0, 0, h}, {1, 0, h}, {1, 0, 0}},
                                  {{0, 1, 0}, {1, 1, 0}, {1, 1, h}, {0, 1, h}},
                                  {{0, 0, h}, {0, 1, h}, {1, 1, h}, {1, 0, h}}};
    outcome out = {.value = NAN};
    for (int degree = 1; degree <= DEGREE_MAX; degree++) {
        hpr_element_frame ground = floor_of(0, 1, 0, 1);
        ground.degree = degree;
        size_t n = frame_basis(&ground);
        double sum[HPR_MAX_BASIS] = {-1};
        for (int j = 0; j < 5; j++) {
            hpr_element_frame other = frame_of_corners(degree, 4, face[j]);
            out.short_of |= block_of(&ground, &other, demanded, block_a).status >= HPR_BLOCK_SHORT;
            for (size_t k = 0; k < n; k++)
                sum[k] += sqrt(other.area_m2) * block_a[k * n];
        }
        for (size_t k = 0; k < n; k++)
            out.error = fmax(out.error, fabs(sum[k]));
    }
    return out;
}

static outcome moments_case(const hard_case *it)
{
    outcome out = {.value = NAN, .error = INFINITY};
    for (int i = 0; i < OPEN_BLOCKS; i++) {
        const open_block *c = &open_blocks[i];
        if (strcmp(c->id, it->id) != 0)
            continue;
        hpr_shape shape = c->triangles ? HPR_SHAPE_TRIANGLE : HPR_SHAPE_PARALLELOGRAM;
        hpr_element_frame recv = frame_of(shape, c->degree, c->recv[0], c->recv[1], c->recv[2]);
        hpr_element_frame send = frame_of(shape, c->degree, c->send[0], c->send[1], c->send[2]);
        size_t n = frame_basis(&send);
        out.short_of = block_of(&recv, &send, demanded, block_a).status >= HPR_BLOCK_SHORT;
        double largest = largest_entry(block_a, n * n), worst = 0;
        for (int k = 0; k < c->entry_count; k++) {
            const open_entry *e = &c->entry[k];
            worst = fmax(worst, fabs(block_a[(size_t)e->row * n + (size_t)e->column] - e->value) / largest);
        }
        out.error = worst;
    }
    return out;
}

static void set_patch(hpr_patches *patches, size_t i, const double (*corner)[3])
{
    hpr_element_frame f = frame_of_corners(0, 4, corner);
    patches->shape[i] = HPR_SHAPE_PARALLELOGRAM;
    patches->twin[i] = HPR_NONE;
    patches->area_m2[i] = f.area_m2;
    hpr_vec3_store(patches->origin + 3 * i, f.origin);
    hpr_vec3_store(patches->edge1 + 3 * i, f.edge1);
    hpr_vec3_store(patches->edge2 + 3 * i, f.edge2);
    hpr_vec3_store(patches->normal + 3 * i, f.normal);
}

/* Unit squares at distance 1; corner2 of the pair is what stands between them. */
static outcome blocked_case(const hard_case *it)
{
    pair p = squares_at(0, 0, 1);
    const uint32_t blocker = 2;
    hpr_patches *patches = NULL;
    hpr_visibility *visibility = NULL;
    double block;
    outcome out = {.error = INFINITY};
    if (hpr_patches_create(bench.context, 3, 1, &patches) != HPR_OK)
        return out;
    set_patch(patches, 0, (const double(*)[3])p.corner1);
    set_patch(patches, 1, (const double(*)[3])p.corner2);
    set_patch(patches, 2, it->pair.corner2);
    if (hpr_visibility_create(patches, &visibility) == HPR_OK) {
        hpr_block_task task = {.recv = frame_of_corners(0, 4, (const double(*)[3])p.corner1),
                               .send = frame_of_corners(0, 4, (const double(*)[3])p.corner2),
                               .tolerance = demanded,
                               .visibility = visibility,
                               .blockers = &blocker,
                               .blocker_count = 1,
                               .clip = true};
        task.contact_m = pair_contact(&task.recv, &task.send);
        hpr_block_result result = hpr_block_ref(bench.quadrature, &task, &block, bench.scratch);
        out = (outcome){.value = it->expected,
                        .error = fabs(block / it->expected - 1),
                        .short_of = result.status >= HPR_BLOCK_SHORT};
    }
    hpr_visibility_destroy(&visibility);
    hpr_patches_destroy(&patches);
    return out;
}

#define CLOSED_FORM "closed form"
#define CONTOUR "contour integral"
#define CONTOUR_40 "contour integral, 40 digits"
#define OPEN_SET "open set"
#define FLOOR                                                                                                \
    {                                                                                                        \
        {0, 0, 0}, {1, 0, 0}, {1, 1, 0},                                                                     \
        {                                                                                                    \
            0, 1, 0                                                                                          \
        }                                                                                                    \
    }
#define WALL                                                                                                 \
    {                                                                                                        \
        {0, 0, 0}, {0, 1, 0}, {0, 1, 1},                                                                     \
        {                                                                                                    \
            0, 0, 1                                                                                          \
        }                                                                                                    \
    }
#define LID(z)                                                                                               \
    {                                                                                                        \
        {0, 0, z}, {0, 1, z}, {1, 1, z},                                                                     \
        {                                                                                                    \
            1, 0, z                                                                                          \
        }                                                                                                    \
    }
#define QUADS(...) .pair = {.count1 = 4, .count2 = 4, __VA_ARGS__}
#define TRIANGLES(...) .pair = {.count1 = 3, .count2 = 3, __VA_ARGS__}

/* The closed forms are good to 15 digits where F is not small, the contour integral to 16 to 17. */
static const hard_case hard_cases[] = {
    {"squares sharing an edge, 1 degree", OPEN_SET, 20, open_case, .id = "ff_inclined_1deg_1x1x1"},
    {"2 degrees", CONTOUR, 15, opened_case, .number = 2},
    {"10 degrees", OPEN_SET, 20, open_case, .id = "ff_inclined_10deg_1x1x1"},
    {"90 degrees", OPEN_SET, 22, open_case, .id = "ff_perp_edge_l1_h1_w1"},
    {"178 degrees", CONTOUR, 14, opened_case, .number = 178},
    {"179 degrees", OPEN_SET, 20, open_case, .id = "ff_inclined_179deg_1x1x1"},
    {"90 degrees, edge 0.01 long", OPEN_SET, 22, open_case, .id = "ff_perp_edge_l0.01_h1_w1"},
    {"90 degrees, a strip 0.001 high", OPEN_SET, 22, open_case, .id = "ff_perp_edge_l1_h0.001_w1"},
    {"triangles sharing an edge, 60 degrees", OPEN_SET, 18, open_case, .id = "ff_tri_edge60"},
    {"squares face to face, gap 1", OPEN_SET, 22, open_case, .id = "ff_parallel_1x1_gap1"},
    {"gap 0.1", OPEN_SET, 22, open_case, .id = "ff_parallel_1x1_gap0.1"},
    {"gap 1e-2", CLOSED_FORM, 15, gap_case, .number = 1e-2},
    {"gap 1e-4", CLOSED_FORM, 15, gap_case, .number = 1e-4},
    {"gap 1e-6", OPEN_SET, 22, open_case, .id = "ff_parallel_1x1_gap1e-6"},
    {"triangles face to face, gap 1e-4", OPEN_SET, 18, open_case, .id = "ff_tri_gap1e-4"},
    {"triangles face to face, gap 1e-6", OPEN_SET, 18, open_case, .id = "ff_tri_gap1e-6"},
    {"wall 0.01 over the edge of a floor", CLOSED_FORM, 15, lifted_case, .number = 1e-2},
    {"wall 1e-4 over the edge", CLOSED_FORM, 15, lifted_case, .number = 1e-4},
    {"wall 1e-6 over the edge", CLOSED_FORM, 15, lifted_case, .number = 1e-6},
    {"sizes 1 : 1e6", OPEN_SET, 18, open_case, .id = "ff_ratio_1e6"},
    {"triangle 1 : 1e4", OPEN_SET, 18, open_case, .id = "ff_sliver_1e4"},
    {"strips 1 : 1e4, gap of a width", OPEN_SET, 20, open_case, .id = "ff_sliverquad_1e-4_gap1e-4"},
    {"strips 1 : 1e4, gap of a length", OPEN_SET, 20, open_case, .id = "ff_sliverquad_1e-4_gap1"},
    {"strips 1 : 100", OPEN_SET, 22, open_case, .id = "ff_parallel_1x100_gap1"},
    {"T: wall on the middle of a floor", CLOSED_FORM, 15, standing_case, .number = 0.75},
    {"T: foot 0.001 of the edge", CLOSED_FORM, 14, short_foot_case, .number = 1e-3},
    {"edges that overlap partly", OPEN_SET, 20, open_case, .id = "ff_quad_edge_partial"},
    {"triangles, edges that overlap partly", OPEN_SET, 18, open_case, .id = "ff_tri_partial_edge"},
    {"wall through a floor", CLOSED_FORM, 15, piercing_case, .number = 0.5},
    {"triangle through the other's plane", OPEN_SET, 18, open_case, .id = "ff_tri_straddle"},
    {"squares sharing a vertex", OPEN_SET, 20, open_case, .id = "ff_quad_vertex"},
    {"triangles sharing a vertex", OPEN_SET, 18, open_case, .id = "ff_tri_vertex"},
    {"needles 1 : 100 sharing the tip, 1 degree", CONTOUR, 15, contour_case,
     TRIANGLES(.corner1 = {{0, 0, 0}, {1, 0, 0}, {1, 0.01, 0}},
               .corner2 = {{0, 0, 0}, {1, 0.01, 0.0175}, {1, 0, 0.0175}})},
    {"needles 1 : 1e4 sharing the tip, 45 degrees", CONTOUR_40, 17, stated_case,
     .expected = 3.4084505533650853e-05,
     TRIANGLES(.corner1 = {{0, 0, 0}, {1, 0, 0}, {1, 1e-4, 0}},
               .corner2 = {{0, 0, 0}, {1, 1e-4, 1}, {1, 0, 1}})},
    {"coplanar, sharing an edge", "exactly 0", 0, open_case, .id = "ff_coplanar_touching"},
    {"coplanar, overlapping", "exactly 0", 0, stated_case,
     QUADS(.corner1 = FLOOR, .corner2 = {{0.5, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0.5, 1, 0}})},
    {"back to back", "exactly 0", 0, stated_case, QUADS(.corner1 = FLOOR, .corner2 = LID(0))},
    {"both facing up", "exactly 0", 0, open_case, .id = "ff_backfacing"},
    {"10,000 sizes apart", CLOSED_FORM, 15, far_facing_case, .number = 1e4},
    {"14,000 sizes apart, at 45 degrees", CLOSED_FORM, 15, far_case, .number = 1e4},
    {"triangles at offset 2^20", OPEN_SET, 20, open_case, .id = "ff_offset_1e6"},
    {"shared edge at offset 2^20", CONTOUR, 15, moved_case, QUADS(.corner1 = FLOOR, .corner2 = WALL)},
    {"gap 2^-13 at offset 2^20", CONTOUR, 15, moved_case, QUADS(.corner1 = FLOOR, .corner2 = LID(0x1p-13))},
    {"size 1e-6", OPEN_SET, 20, open_case, .id = "ff_scale_1e-6"},
    {"size 1e6", OPEN_SET, 20, open_case, .id = "ff_scale_1e6"},
    {"shared edge, sizes 2^-100 to 2^100, degree 2", "the same bits", 0, bits_case,
     QUADS(.corner1 = FLOOR, .corner2 = WALL)},
    {"gap 0.1, sizes 2^-100 to 2^100, degree 2", "the same bits", 0, bits_case,
     QUADS(.corner1 = FLOOR, .corner2 = LID(0.1))},
    {"blocked by a square halfway", OPEN_SET, 14, blocked_case, .expected = 0.0995062945989844,
     QUADS(.corner2 = {{0.25, 0.25, 0.5}, {0.75, 0.25, 0.5}, {0.75, 0.75, 0.5}, {0.25, 0.75, 0.5}})},
    {"by a small square", OPEN_SET, 14, blocked_case, .expected = 0.191672379584829,
     QUADS(.corner2 =
               {{0.4375, 0.4375, 0.5}, {0.5625, 0.4375, 0.5}, {0.5625, 0.5625, 0.5}, {0.4375, 0.5625, 0.5}})},
    {"by a square close to the receiver", OPEN_SET, 14, blocked_case, .expected = 0.137164323083803,
     QUADS(.corner2 =
               {{0.25, 0.25, 0.0625}, {0.75, 0.25, 0.0625}, {0.75, 0.75, 0.0625}, {0.25, 0.75, 0.0625}})},
    {"by a square on its tip", OPEN_SET, 14, blocked_case, .expected = 0.0901656683525704,
     QUADS(.corner2 = {{0.5, 0.125, 0.5}, {0.875, 0.5, 0.5}, {0.5, 0.875, 0.5}, {0.125, 0.5, 0.5}})},
    {"moments, gap 0.1, degree 3", OPEN_SET, 18, moments_case, .id = "mom_parallel_gap0.1"},
    {"moments, shared edge, degree 3", OPEN_SET, 16, moments_case, .id = "mom_edge_90deg"},
    {"moments, triangles sharing an edge, degree 2", OPEN_SET, 14, moments_case, .id = "mom_tri_edge90"},
    {"moments, triangles sharing a vertex, degree 2", OPEN_SET, 15, moments_case, .id = "mom_tri_vertex"},
    {"moments, gap 0.25, degree 16", OPEN_SET, 18, moments_case, .id = "mom_highp_parallel_gap0.25"},
    {"closed cube, degrees 1 to 8", "closure", 15, closure_case, .number = 1},
    {"closed box 1 x 1 x 0.25, degrees 1 to 8", "closure", 15, closure_case, .number = 0.25},
    {"closed box 1 x 1 x 0.01, degrees 1 to 8", "closure", 15, closure_case, .number = 0.01},
    {"closed box 1 x 1 x 1e-6, degrees 1 to 8", "closure", 15, closure_case, .number = 1e-6},
    {"shared edge, degrees 1 to 8", "reciprocity", 15, reciprocity_case,
     QUADS(.corner1 = FLOOR, .corner2 = {{0, 0, 0}, {0, 1, 0}, {0.5, 1, 1}, {0.5, 0, 1}})},
    {"gap 0.1, degrees 1 to 8", "reciprocity", 15, reciprocity_case,
     QUADS(.corner1 = FLOOR, .corner2 = {{0.3, 0, 0.1}, {0.3, 1, 0.1}, {1.3, 1, 0.2}, {1.3, 0, 0.2}})},
    {"triangles sharing a vertex, degrees 1 to 8", "reciprocity", 15, reciprocity_case,
     TRIANGLES(.corner1 = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
               .corner2 = {{0, 0, 0}, {-0.25, 1, 1}, {1, -0.25, 1}})},
};

static double now(void)
{
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void print_row(const hard_case *it, const outcome *out, double bound, double seconds)
{
    char value[32] = "", reached[32] = "0";
    if (out->error > 0)
        snprintf(reached, sizeof reached, "%.1e", out->error);
    if (!isnan(out->value))
        snprintf(value, sizeof value, "%.10g", out->value);
    if (bound > 0) /* the next power of ten; below 1e-15 it is the rounding of the reference */
        snprintf(reached, sizeof reached, "1e%+03.0f", ceil(log10(fmax(out->error, 1e-15))));
    printf("| %s | %s | %s | ", it->name, value, it->known);
    if (bound > 0)
        printf("%.0e", bound);
    else
        printf("0");
    printf(" | %s |", reached);
    if (seconds >= 0)
        printf(" %.2e | %.3f |", out->error, seconds);
    printf("\n");
}

int main(int argc, char **argv)
{
    bool details = argc == 2 && strcmp(argv[1], "--details") == 0;
    int missed = 0;
    if (argc > 1 && !details) {
        fprintf(stderr, "usage: hard_cases [--details]\n");
        return 2;
    }
    if (bench_open(NULL)) {
        fprintf(stderr, "hard_cases: no memory\n");
        return 1;
    }
    printf("| case | F12 | known from | reachable | reached |%s\n", details ? " error | seconds |" : "");
    printf("| --- | --- | --- | --- | --- |%s\n", details ? " --- | --- |" : "");
    for (size_t i = 0; i < sizeof hard_cases / sizeof *hard_cases; i++) {
        const hard_case *it = &hard_cases[i];
        double begin = now(), bound = it->digits ? fmax(best, pow(10, -it->digits)) : 0;
        outcome out = it->measure(it);
        print_row(it, &out, bound, details ? now() - begin : -1);
        if (!(out.error <= bound) || out.short_of) {
            fprintf(stderr, "%s: error %.3g, bound %.0e%s\n", it->name, out.error, bound,
                    out.short_of ? "; stopped short" : "");
            missed++;
        }
    }
    bench_close(NULL);
    return missed > 0;
}
