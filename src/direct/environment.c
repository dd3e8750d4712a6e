#include "direct/environment.h"

#include "direct/lambert.h"
#include "math/hash.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_OCCLUDERS = 512, /* beyond, a point costs milliseconds */
    MAX_CORNERS = 3072,  /* of all of them */
    FEW = 64,            /* occluders in a cone that are clipped */
    MAX_CONES = 4096,    /* per point */
    MAX_DEPTH = 40,      /* halvings of a cone */
};

struct hpr_environment {
    hpr_context *context;
    const hpr_patches *patches;
    const hpr_elements *elements;
    hpr_visibility *visibility;
    size_t occluder_count;
    hpr_convex *outline; /* [occluder_count] */
    hpr_vec3 *normal;    /* [occluder_count] length 1 */
    double size;         /* of the scene, metres */
    double reach;        /* metres within which surfaces touch: welding moves corners by as much */
};

bool hpr_environment_affordable(const hpr_environment *environment)
{
    int corners = 0;
    for (size_t i = 0; i < environment->occluder_count && corners <= MAX_CORNERS; i++)
        corners += environment->outline[i].count;
    return environment->occluder_count <= MAX_OCCLUDERS && corners <= MAX_CORNERS;
}

void hpr_environment_destroy(hpr_environment **out)
{
    hpr_environment *environment = *out;
    if (!environment)
        return;
    hpr_context *ctx = environment->context;
    hpr_visibility_destroy(&environment->visibility);
    hpr_release(ctx, environment->outline);
    hpr_release(ctx, environment->normal);
    hpr_release(ctx, environment);
    *out = NULL;
}

static hpr_vec3 unit(hpr_vec3 a)
{
    return hpr_scale(a, 1 / hpr_length(a));
}

/* Twice the area times the normal. */
static hpr_vec3 outline_vector(const hpr_convex *outline)
{
    hpr_vec3 sum = {0, 0, 0};
    for (int i = 1; i + 1 < outline->count; i++)
        sum = hpr_add(sum, hpr_cross(hpr_sub(outline->corner[i], outline->corner[0]),
                                     hpr_sub(outline->corner[i + 1], outline->corner[0])));
    return sum;
}

/* Falling area, then corner by corner, so that equal ones are in one order. */
static int compare_outlines(const void *a, const void *b)
{
    const hpr_convex *p = a, *q = b;
    double area_p = hpr_length(outline_vector(p)), area_q = hpr_length(outline_vector(q));
    if (area_p != area_q)
        return area_p < area_q ? 1 : -1;
    if (p->count != q->count)
        return p->count < q->count ? 1 : -1;
    return memcmp(p->corner, q->corner, (size_t)p->count * sizeof *p->corner);
}

/* Large ones first: they cover whole cones. */
static void set_occluders(hpr_environment *environment)
{
    const hpr_patches *patches = environment->patches;
    double centre[3], radius = hpr_patches_radius(patches, centre), largest = radius;
    for (int k = 0; k < 3; k++)
        largest = fmax(largest, fabs(centre[k]) + radius);
    environment->size = 2 * radius;
    environment->reach = fmax(2e-9 * radius + 8 * DBL_EPSILON * largest, 2 * patches->weld_m);
    memcpy(environment->outline, hpr_visibility_outlines(environment->visibility),
           environment->occluder_count * sizeof *environment->outline);
    qsort(environment->outline, environment->occluder_count, sizeof *environment->outline, compare_outlines);
    for (size_t i = 0; i < environment->occluder_count; i++)
        environment->normal[i] = unit(outline_vector(&environment->outline[i]));
}

hpr_status hpr_environment_create(const hpr_patches *patches, const hpr_elements *elements,
                                  hpr_environment **out)
{
    static const char what[] = "light from outside";
    hpr_context *ctx = patches->context;
    hpr_environment *environment = NULL;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &environment, 1, sizeof *environment, what);
    if (status != HPR_OK)
        return status;
    environment->context = ctx;
    environment->patches = patches;
    environment->elements = elements;
    status = hpr_visibility_create(patches, &environment->visibility);
    if (status == HPR_OK)
        environment->occluder_count = hpr_visibility_occluder_count(environment->visibility);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &environment->outline, environment->occluder_count,
                                   sizeof *environment->outline, what);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &environment->normal, environment->occluder_count,
                                   sizeof *environment->normal, what);
    if (status == HPR_OK)
        set_occluders(environment);
    else
        hpr_environment_destroy(&environment);
    *out = environment;
    return status;
}

const hpr_visibility *hpr_environment_visibility(const hpr_environment *environment)
{
    return environment->visibility;
}

const hpr_convex *hpr_environment_outlines(const hpr_environment *environment, size_t *count)
{
    *count = environment->occluder_count;
    return environment->outline;
}

/* An occluder as the point sees it: corners and sides in the view's arrays. */
typedef struct shape {
    uint16_t first, corner_count, side_count;
} shape;

/* What a point sees before the environment; vectors are relative to the point. */
typedef struct view {
    hpr_vec3 normal; /* of the receiver */
    int count;
    shape shape[MAX_OCCLUDERS];
    hpr_vec3 corner[MAX_CORNERS];
    hpr_side side[MAX_CORNERS]; /* with normals of length 1 */
    int cones;
    double unresolved;
    hpr_visible visible; /* scratch */
} view;

/* A triangular cone of directions: corners of length 1, and the inward planes through its sides. */
typedef struct cone {
    hpr_vec3 corner[3], side[3];
} cone;

static cone make_cone(hpr_vec3 a, hpr_vec3 b, hpr_vec3 c)
{
    return (cone){{a, b, c}, {hpr_cross(a, b), hpr_cross(b, c), hpr_cross(c, a)}};
}

static double cone_part(const view *v, const cone *it)
{
    static const double origin[3] = {0, 0, 0};
    double normal[3], corner[3][3];
    hpr_vec3_store(normal, v->normal);
    for (int k = 0; k < 3; k++)
        hpr_vec3_store(corner[k], it->corner[k]);
    return hpr_lambert_fraction(origin, normal, (const double(*)[3])corner, 3);
}

typedef enum relation { APART, COVERS, CROSSES } relation;

static relation relate(const view *v, const cone *it, const shape *s)
{
    static const double rounding = 1e-14;
    const hpr_side *side = v->side + s->first;
    const hpr_vec3 *corner = v->corner + s->first;
    bool covers = true;
    for (int k = 0; k < s->side_count; k++) {
        int outside = 0;
        for (int i = 0; i < 3; i++) {
            double height = hpr_dot(side[k].normal, it->corner[i]);
            outside += height <= 0;
            covers &= height >= -rounding;
        }
        if (outside == 3)
            return APART;
    }
    if (covers)
        return COVERS;
    for (int k = 0; k < 3; k++) {
        int i = 0;
        while (i < s->corner_count && hpr_dot(it->side[k], corner[i]) <= 0)
            i++;
        if (i == s->corner_count)
            return APART;
    }
    return CROSSES;
}

/* False if the pieces became too many. */
static bool clip_cone(view *v, const cone *it, const uint16_t *listed, int count, double *part)
{
    v->visible.count = 1;
    v->visible.whole = true;
    v->visible.hidden = NULL;
    v->visible.piece[0].count = 3;
    memcpy(v->visible.piece[0].corner, it->corner, sizeof it->corner);
    for (int i = 0; i < count && v->visible.count > 0; i++) {
        const shape *s = &v->shape[listed[i]];
        if (!hpr_visible_subtract(&v->visible, v->side + s->first, s->side_count))
            return false;
    }
    *part = hpr_visible_fraction(v->normal, &v->visible);
    return true;
}

static bool holds(const view *v, const shape *s, hpr_vec3 direction)
{
    int k = 0;
    while (k < s->side_count && hpr_dot(v->side[s->first + k].normal, direction) >= 0)
        k++;
    return k == s->side_count;
}

/* Decides the cone by its middle. */
static double guess_cone(view *v, const cone *it, const uint16_t *listed, int count)
{
    hpr_vec3 middle = hpr_add(it->corner[0], hpr_add(it->corner[1], it->corner[2]));
    double part = cone_part(v, it);
    v->unresolved += part;
    for (int i = 0; i < count; i++) {
        if (holds(v, &v->shape[listed[i]], middle))
            return 0;
    }
    return part;
}

static double open_part(view *v, const cone *it, const uint16_t *listed, int count, int depth)
{
    uint16_t left[MAX_OCCLUDERS];
    int left_count = 0;
    v->cones++;
    for (int i = 0; i < count; i++) {
        relation r = relate(v, it, &v->shape[listed[i]]);
        if (r == COVERS)
            return 0;
        if (r == CROSSES)
            left[left_count++] = listed[i];
    }
    double part;
    if (left_count == 0)
        return cone_part(v, it);
    if (left_count <= FEW && clip_cone(v, it, left, left_count, &part))
        return part;
    if (depth >= MAX_DEPTH || v->cones >= MAX_CONES)
        return clip_cone(v, it, left, left_count, &part) ? part : guess_cone(v, it, left, left_count);
    int a = 0;
    double longest = 0;
    for (int k = 0; k < 3; k++) {
        double length = hpr_length(hpr_sub(it->corner[(k + 1) % 3], it->corner[k]));
        if (length > longest) {
            longest = length;
            a = k;
        }
    }
    hpr_vec3 from = it->corner[a], to = it->corner[(a + 1) % 3], tip = it->corner[(a + 2) % 3];
    hpr_vec3 middle = unit(hpr_add(from, to));
    const cone half[2] = {make_cone(from, middle, tip), make_cone(middle, to, tip)};
    return open_part(v, &half[0], left, left_count, depth + 1) +
           open_part(v, &half[1], left, left_count, depth + 1);
}

/* In the closed polygon, to within `reach`. */
static bool touches(const hpr_convex *outline, hpr_vec3 normal, hpr_vec3 point, double reach)
{
    if (!(fabs(hpr_dot(normal, hpr_sub(point, outline->corner[0]))) <= reach))
        return false;
    for (int i = 0; i < outline->count; i++) {
        hpr_vec3 from = outline->corner[i], along = hpr_sub(outline->corner[(i + 1) % outline->count], from);
        hpr_vec3 inward = hpr_cross(normal, along);
        if (hpr_dot(inward, hpr_sub(point, from)) < -reach * hpr_length(along))
            return false;
    }
    return true;
}

/* Is the occluder the surface itself that the point is on, which as a whole may lean by what corners move
 * when they are welded? */
static bool is_ground(const hpr_environment *environment, size_t occluder, hpr_vec3 normal, hpr_vec3 point)
{
    static const double parallel = 1e-3;
    return hpr_length(hpr_cross(normal, environment->normal[occluder])) <= parallel &&
           touches(&environment->outline[occluder], environment->normal[occluder], point, environment->reach);
}

/* Adds an occluder that rises over the horizon; returns where the next one's corners begin. */
static int add_occluder(view *v, const hpr_environment *environment, size_t occluder, hpr_vec3 point,
                        int first)
{
    const hpr_convex *outline = &environment->outline[occluder];
    hpr_convex relative = {.count = outline->count};
    hpr_side side[HPR_VISIBLE_CORNERS];
    double height = 0;
    for (int i = 0; i < outline->count; i++) {
        relative.corner[i] = hpr_sub(outline->corner[i], point);
        height = fmax(height, hpr_dot(v->normal, relative.corner[i]));
    }
    if (!(height > environment->reach) || is_ground(environment, occluder, v->normal, point))
        return first;
    int sides = hpr_visible_pyramid(&relative, side);
    if (sides == 0)
        return first;
    memcpy(v->corner + first, relative.corner, (size_t)relative.count * sizeof *relative.corner);
    for (int k = 0; k < sides; k++) {
        double scale = 1 / hpr_length(side[k].normal);
        v->side[first + k] = (hpr_side){hpr_scale(side[k].normal, scale), scale * side[k].rounding};
    }
    v->shape[v->count++] = (shape){(uint16_t)first, (uint16_t)relative.count, (uint16_t)sides};
    return first + relative.count;
}

hpr_opening hpr_environment_opening(const hpr_environment *environment, size_t patch, hpr_vec3 point)
{
    static const double closed = 1e-12; /* what rounding leaves of a closed view */
    const hpr_patches *patches = environment->patches;
    view v; /* large, and what is not set here is never read */
    uint16_t listed[MAX_OCCLUDERS];
    int next = 0;
    v.normal = hpr_vec3_load(patches->normal + 3 * patch);
    v.count = v.cones = 0;
    v.unresolved = 0;
    for (size_t i = 0; i < environment->occluder_count; i++)
        next = add_occluder(&v, environment, i, point, next);
    for (int i = 0; i < v.count; i++)
        listed[i] = (uint16_t)i;
    hpr_vec3 u = unit(hpr_vec3_load(patches->edge1 + 3 * patch)), w = hpr_cross(v.normal, u);
    const hpr_vec3 side[4] = {u, w, hpr_scale(u, -1), hpr_scale(w, -1)};
    double part = 0;
    for (int k = 0; k < 4 && v.count > 0; k++) {
        const cone quarter = make_cone(side[k], side[(k + 1) % 4], v.normal);
        part += open_part(&v, &quarter, listed, v.count, 0);
    }
    if (v.count == 0)
        part = 1;
    return (hpr_opening){part < closed ? 0 : part, v.unresolved};
}

hpr_opening hpr_environment_sample(const hpr_environment *environment, size_t patch, hpr_vec3 point, int side,
                                   uint64_t seed)
{
    enum { LATTICES = 4 };
    static const double golden = 0.61803398874989485;
    const hpr_patches *patches = environment->patches;
    hpr_vec3 n = hpr_vec3_load(patches->normal + 3 * patch);
    hpr_vec3 u = unit(hpr_vec3_load(patches->edge1 + 3 * patch)), v = hpr_cross(n, u);
    double near = 0.5e-9 * environment->size + patches->weld_m, origin[3], mean[LATTICES], sum = 0,
           square = 0;
    int rays = side * side;
    hpr_vec3_store(origin, point);
    for (uint64_t lattice = 0; lattice < LATTICES; lattice++) {
        double shift_a = hpr_hash_unit(2 * (LATTICES * seed + lattice) + 1);
        double shift_b = hpr_hash_unit(2 * (LATTICES * seed + lattice) + 2);
        int open = 0;
        for (int i = 0; i < rays; i++) {
            double a = fmod((i + 0.5) / rays + shift_a, 1), b = fmod(i * golden + shift_b, 1), direction[3];
            double radius = sqrt(a), angle = 2 * 3.14159265358979323846 * b;
            hpr_vec3 d = hpr_madd(hpr_scale(n, sqrt(1 - a)), radius * cos(angle), u);
            hpr_vec3_store(direction, hpr_madd(d, radius * sin(angle), v));
            open += hpr_visibility_first_hit(environment->visibility, origin, direction, near, INFINITY,
                                             false, NULL)
                        .patch == HPR_NONE;
        }
        mean[lattice] = (double)open / rays;
        sum += mean[lattice];
    }
    for (int k = 0; k < LATTICES; k++)
        square += (mean[k] - sum / LATTICES) * (mean[k] - sum / LATTICES);
    return (hpr_opening){sum / LATTICES, sqrt(square / (LATTICES * (LATTICES - 1)))};
}

void hpr_environment_limit(const hpr_environment *environment, size_t leaf, double *s, double *t)
{
    static const double least = 1e-6, most = 1e-2, parallel = 1e-3;
    const hpr_elements *e = environment->elements;
    size_t node = e->leaf[leaf], patch = e->patch[node];
    hpr_vec3 edge1 = hpr_vec3_load(e->edge1 + 3 * node), edge2 = hpr_vec3_load(e->edge2 + 3 * node);
    hpr_vec3 x = hpr_madd(hpr_madd(hpr_vec3_load(e->origin + 3 * node), *s, edge1), *t, edge2);
    hpr_vec3 normal = hpr_vec3_load(environment->patches->normal + 3 * patch);
    bool moved = false;
    for (size_t i = 0; i < environment->occluder_count && !moved; i++) {
        hpr_vec3 other = environment->normal[i];
        moved = touches(&environment->outline[i], other, x, environment->reach) &&
                hpr_length(hpr_cross(normal, other)) > parallel;
    }
    if (!moved)
        return;
    /* Out of reach of what touches, also where the leaf is slender. */
    double length = hpr_length(edge1) + hpr_length(edge2), width = e->area_m2[node] / length;
    double inward = fmin(fmax(least, 8 * environment->reach / width), most);
    double middle[2];
    hpr_shape_middle((hpr_shape)environment->patches->shape[patch], e->opposite + 2 * node, middle);
    *s += inward * (middle[0] - *s);
    *t += inward * (middle[1] - *t);
}
