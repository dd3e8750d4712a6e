#include "baseline/hemicube.h"

#include "math/vec3.h"

#include <float.h>
#include <omp.h>
#include <stdatomic.h>
#include <string.h>

enum { FACES = 5 };

/* A face of the cube with half edge 1: its pixels look along forward + x right + y up, x from -1 to 1, y from
 * `low` to 1. */
typedef struct face {
    hpr_vec3 right, up, forward;
    double low;
    int rows;
} face;

/*
 * A patch as one face shows it, affine functions f[0] x + f[1] y + f[2] of the place on the face: its inverse
 * depth, and s and t of the point seen times that. (Heckbert 1989: what is affine on a plane is, divided by
 * the depth, affine on its picture.)
 */
typedef struct outlook {
    double nearness[3], s[3], t[3];
} outlook;

typedef struct canvas {
    double *nearness; /* [resolution][resolution] 1 / depth, 0: nothing */
    uint32_t *item;   /* [resolution][resolution] patch, or HPR_NONE: nothing, or a back */
    outlook *looks;   /* [patches] */
} canvas;

typedef struct hemicubes {
    const hpr_patches *patches;
    const hpr_elements *elements;
    int resolution;
    double *top;  /* [resolution][resolution] share of each pixel of what is seen */
    double *side; /* [resolution / 2][resolution] */
    canvas *canvases;
    double *factor;
} hemicubes;

/* The middle of pixel i of n in -1 .. 1, and the number of the first pixel with its middle at or after x. */
static double middle(int i, int n)
{
    return (2 * i + 1) / (double)n - 1;
}

static int first_from(double x, int n)
{
    double i = ceil(0.5 * ((x + 1) * n - 1));
    return i < 0 ? 0 : i > n ? n : (int)i; /* i > n: also beyond the range of int */
}

static void fill_shares(hemicubes *h)
{
    const double pi = 3.14159265358979323846;
    int n = h->resolution;
    double pixel_area = 4.0 / ((double)n * n);
    for (int r = 0; r < n; r++) {
        double y = middle(r, n);
        for (int i = 0; i < n; i++) {
            double x = middle(i, n), square = x * x + y * y + 1;
            h->top[(size_t)r * n + i] = pixel_area / (pi * square * square);
            if (r >= n / 2)
                h->side[(size_t)(r - n / 2) * n + i] = y * pixel_area / (pi * square * square);
        }
    }
}

static void make_faces(const hpr_elements *e, size_t node, const hpr_vec3 *normal, int resolution,
                       face faces[FACES])
{
    hpr_vec3 u = hpr_vec3_load(e->edge1 + 3 * node);
    u = hpr_scale(u, 1 / hpr_length(u));
    hpr_vec3 n = *normal, v = hpr_cross(n, u);
    hpr_vec3 left = hpr_scale(u, -1), back = hpr_scale(v, -1);
    const face all[FACES] = {{u, v, n, -1, resolution},
                             {v, n, u, 0, resolution / 2},
                             {back, n, left, 0, resolution / 2},
                             {left, n, v, 0, resolution / 2},
                             {u, n, back, 0, resolution / 2}};
    memcpy(faces, all, sizeof all);
}

/* A vector as an affine function of the place on a face: f . (x, y, 1) = vector . direction. */
static void on_face(const face *f, hpr_vec3 vector, double factor, double result[3])
{
    result[0] = factor * hpr_dot(vector, f->right);
    result[1] = factor * hpr_dot(vector, f->up);
    result[2] = factor * hpr_dot(vector, f->forward);
}

/* Is the polygon wholly to one side of what the face shows? Else the rows that it may have. */
static bool find_rows(const face *f, int n, size_t count, const double corner[4][3], int *first, int *end)
{
    int left = 0, right = 0, below = 0, above = 0, behind = 0;
    double low = INFINITY, high = -INFINITY;
    for (size_t k = 0; k < count; k++) {
        double x = corner[k][0], y = corner[k][1], z = corner[k][2];
        left += x < -z;
        right += x > z;
        below += y < f->low * z;
        above += y > z;
        behind += z <= 0;
        low = fmin(low, z > 0 ? y / z : -INFINITY);
        high = fmax(high, z > 0 ? y / z : INFINITY);
    }
    int all = (int)count;
    if (left == all || right == all || below == all || above == all || behind == all)
        return false;
    /* A corner behind may show the polygon anywhere. One row more on either side: y / z is rounded. */
    *first = first_from(fmax(low, f->low), n) - 1;
    *end = first_from(fmin(high, 1), n) + 1;
    if (*first < n - f->rows)
        *first = n - f->rows;
    if (*end > n)
        *end = n;
    return true;
}

/* The pixels of row y that lie within all edges: [*first, *end). What two polygons share as an edge falls to
 * exactly one of them, for a crossing is rounded the same way from either side. */
static void find_span(size_t count, const double edge[4][3], double y, int n, int *first, int *end)
{
    *first = 0;
    *end = n;
    for (size_t k = 0; k < count && *first < *end; k++) {
        double slope = edge[k][0], rest = edge[k][1] * y + edge[k][2];
        if (slope == 0) {
            if (rest < 0)
                *end = 0;
            continue;
        }
        int crossing = first_from(-rest / slope, n);
        if (slope > 0 && crossing > *first)
            *first = crossing;
        else if (slope < 0 && crossing < *end)
            *end = crossing;
    }
}

/* How s and t of the points of a patch go over a face, times the inverse depth:
 *   s = a . (eye + d / w - origin) with a the dual of edge1, so that s w = a . d + (a . (eye - origin)) w. */
static void set_parameters(const hpr_patches *patches, const face *f, size_t patch, hpr_vec3 eye,
                           outlook *look)
{
    hpr_vec3 edge1 = hpr_vec3_load(patches->edge1 + 3 * patch),
             edge2 = hpr_vec3_load(patches->edge2 + 3 * patch);
    hpr_vec3 across = hpr_cross(edge1, edge2);
    double square = hpr_dot(across, across);
    hpr_vec3 dual1 = hpr_scale(hpr_cross(edge2, across), 1 / square),
             dual2 = hpr_scale(hpr_cross(across, edge1), 1 / square);
    hpr_vec3 offset = hpr_sub(eye, hpr_vec3_load(patches->origin + 3 * patch));
    on_face(f, dual1, 1, look->s);
    on_face(f, dual2, 1, look->t);
    for (int k = 0; k < 3; k++) {
        look->s[k] += hpr_dot(dual1, offset) * look->nearness[k];
        look->t[k] += hpr_dot(dual2, offset) * look->nearness[k];
    }
}

/* The patch drawn on one face: eye is in front of its plane by `height`, behind it if negative. */
static void draw(const hemicubes *h, const face *f, canvas *c, size_t patch, hpr_vec3 eye, double height)
{
    const hpr_patches *patches = h->patches;
    int n = h->resolution, first_row, end_row;
    double world[4][3], corner[4][3], edge[4][3];
    size_t count = hpr_patch_corners(patches, patch, world);
    hpr_vec3 ray[4];
    for (size_t k = 0; k < count; k++) {
        ray[k] = hpr_sub(hpr_vec3_load(world[k]), eye);
        on_face(f, ray[k], 1, corner[k]);
    }
    if (!find_rows(f, n, count, (const double(*)[3])corner, &first_row, &end_row))
        return;
    for (size_t k = 0; k < count; k++)
        on_face(f, hpr_cross(ray[k], ray[(k + 1) % count]), height > 0 ? -1 : 1, edge[k]);
    on_face(f, hpr_vec3_load(patches->normal + 3 * patch), -1 / height, c->looks[patch].nearness);
    set_parameters(patches, f, patch, eye, &c->looks[patch]);
    const double *nearness = c->looks[patch].nearness;
    for (int r = first_row; r < end_row; r++) {
        double y = middle(r, n), rest = nearness[1] * y + nearness[2];
        int first, end;
        find_span(count, (const double(*)[3])edge, y, n, &first, &end);
        for (int i = first; i < end; i++) {
            double near = nearness[0] * middle(i, n) + rest;
            if (near > c->nearness[(size_t)r * n + i]) {
                c->nearness[(size_t)r * n + i] = near;
                c->item[(size_t)r * n + i] = height > 0 ? (uint32_t)patch : HPR_NONE;
            }
        }
    }
}

static double affine(const double f[3], double x, double y)
{
    return f[0] * x + (f[1] * y + f[2]);
}

/* Adds the shares of the pixels of a face to what they show. */
static void collect(const hemicubes *h, const face *f, const canvas *c, double *row)
{
    const hpr_elements *e = h->elements;
    int n = h->resolution;
    const double *shares = f->rows == n ? h->top : h->side;
    for (int r = n - f->rows; r < n; r++) {
        double y = middle(r, n);
        for (int i = 0; i < n; i++) {
            uint32_t patch = c->item[(size_t)r * n + i];
            if (patch == HPR_NONE)
                continue;
            size_t leaf = e->patch_leaf[patch];
            if (e->patch_leaf[patch + 1] - leaf > 1) {
                const outlook *look = &c->looks[patch];
                double x = middle(i, n), near = c->nearness[(size_t)r * n + i], s, t;
                leaf = hpr_elements_locate(h->patches, e, patch, affine(look->s, x, y) / near,
                                           affine(look->t, x, y) / near, &s, &t);
            }
            row[leaf] += shares[(size_t)(r - (n - f->rows)) * n + i];
        }
    }
}

static void look_around(const hemicubes *h, canvas *c, size_t leaf)
{
    const hpr_patches *patches = h->patches;
    const hpr_elements *e = h->elements;
    size_t node = e->leaf[leaf], pixels = (size_t)h->resolution * (size_t)h->resolution;
    double middle_of[2];
    hpr_shape_middle((hpr_shape)patches->shape[e->patch[node]], e->opposite + 2 * node, middle_of);
    hpr_vec3 normal = hpr_vec3_load(patches->normal + 3 * e->patch[node]);
    hpr_vec3 eye = hpr_madd(
        hpr_madd(hpr_vec3_load(e->origin + 3 * node), middle_of[0], hpr_vec3_load(e->edge1 + 3 * node)),
        middle_of[1], hpr_vec3_load(e->edge2 + 3 * node));
    face faces[FACES];
    make_faces(e, node, &normal, h->resolution, faces);
    for (int k = 0; k < FACES; k++) {
        memset(c->nearness, 0, pixels * sizeof *c->nearness);
        memset(c->item, 0xff, pixels * sizeof *c->item); /* HPR_NONE */
        for (size_t p = 0; p < patches->count; p++) {
            hpr_vec3 to_eye = hpr_sub(eye, hpr_vec3_load(patches->origin + 3 * p));
            double height = hpr_dot(to_eye, hpr_vec3_load(patches->normal + 3 * p));
            bool twin_shows = height < 0 && patches->twin[p] != HPR_NONE;
            if (fabs(height) <= patches->weld_m || twin_shows)
                continue; /* in one plane, and what touches it hides nothing */
            draw(h, &faces[k], c, p, eye, height);
        }
        collect(h, &faces[k], c, h->factor + leaf * e->leaf_count);
    }
}

static hpr_status allocate(hemicubes *h)
{
    hpr_context *ctx = h->patches->context;
    size_t n = (size_t)h->resolution, threads = (size_t)hpr_context_threads(ctx);
    hpr_status status = hpr_allocate_into(ctx, &h->top, n * n, sizeof *h->top, "a hemicube");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &h->side, n / 2 * n, sizeof *h->side, "a hemicube");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &h->canvases, threads, sizeof *h->canvases, "a hemicube");
    for (size_t k = 0; status == HPR_OK && k < threads; k++) {
        canvas *c = &h->canvases[k];
        status = hpr_allocate_into(ctx, &c->nearness, n * n, sizeof *c->nearness, "a hemicube");
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &c->item, n * n, sizeof *c->item, "a hemicube");
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &c->looks, h->patches->count, sizeof *c->looks, "a hemicube");
    }
    return status;
}

static void release(hemicubes *h)
{
    hpr_context *ctx = h->patches->context;
    for (int k = 0; h->canvases && k < hpr_context_threads(ctx); k++) {
        hpr_release(ctx, h->canvases[k].nearness);
        hpr_release(ctx, h->canvases[k].item);
        hpr_release(ctx, h->canvases[k].looks);
    }
    hpr_release(ctx, h->canvases);
    hpr_release(ctx, h->top);
    hpr_release(ctx, h->side);
}

hpr_status hpr_hemicube_factors(const hpr_patches *patches, const hpr_elements *elements, int resolution,
                                double *factor)
{
    hpr_context *ctx = patches->context;
    hemicubes h = {.patches = patches, .elements = elements, .resolution = resolution, .factor = factor};
    hpr_status status = allocate(&h);
    atomic_size_t done = 0;
    if (status == HPR_OK) {
        fill_shares(&h);
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
        for (size_t leaf = 0; leaf < elements->leaf_count; leaf++) {
            if (hpr_cancelled(ctx))
                continue;
            look_around(&h, &h.canvases[omp_get_thread_num()], leaf);
            size_t finished = atomic_fetch_add(&done, 1) + 1;
            if (omp_get_thread_num() == 0)
                hpr_stage_progress(ctx, (double)finished / (double)elements->leaf_count);
        }
        if (hpr_cancelled(ctx))
            status = hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while drawing hemicubes");
    }
    release(&h);
    return status;
}
