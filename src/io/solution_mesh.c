#include "io/solution_mesh.h"

#include "reconstruct/reconstruct.h"

#include <math.h>
#include <string.h>

enum { MOST_VERTICES = 2000000, DEEPEST = 64 };
static const double pi = 3.14159265358979323846;

/* Which nodes are shown, and how finely. */
typedef struct plan {
    int depth;    /* deeper nodes are shown by their ancestor of this depth */
    size_t cells; /* at most so many per axis */
    size_t node_count, vertex_count, index_count;
} plan;

/* A node that is shown, and where its part of the arrays begins. */
typedef struct piece {
    uint32_t node;
    uint32_t cells;
    size_t first_vertex, first_index;
} piece;

static bool is_triangle(const hpr_solution *solution, uint32_t node)
{
    return solution->patches->shape[solution->elements->patch[node]] == HPR_SHAPE_TRIANGLE;
}

/* Appends what is shown below `node` to `pieces` (NULL: only counts). */
static void walk(const hpr_solution *solution, plan *p, piece *pieces, uint32_t node, int depth)
{
    const hpr_elements *elements = solution->elements;
    if (elements->child[node] != HPR_NONE && depth < p->depth) {
        walk(solution, p, pieces, elements->child[node], depth + 1);
        walk(solution, p, pieces, elements->child[node] + 1, depth + 1);
        return;
    }
    size_t cells = elements->degree[node] > 1 ? elements->degree[node] : 1;
    if (cells > p->cells)
        cells = p->cells;
    bool triangle = is_triangle(solution, node);
    if (pieces)
        pieces[p->node_count] = (piece){node, (uint32_t)cells, p->vertex_count, p->index_count};
    p->node_count++;
    p->vertex_count += triangle ? (cells + 1) * (cells + 2) / 2 : (cells + 1) * (cells + 1);
    p->index_count += triangle ? 3 * cells * cells : 6 * cells * cells;
}

static void count(const hpr_solution *solution, plan *p, piece *pieces)
{
    p->node_count = p->vertex_count = p->index_count = 0;
    for (size_t i = 0; i < solution->patches->count; i++)
        walk(solution, p, pieces, (uint32_t)i, 0);
}

/* Gives up smoothness first, then elements. With more patches than vertices allowed, each still gets a cell.
 */
static plan choose(const hpr_solution *solution)
{
    plan p = {.depth = DEEPEST, .cells = HPR_MAX_ORDER};
    count(solution, &p, NULL);
    while (p.vertex_count > MOST_VERTICES && (p.cells > 1 || p.depth > 0)) {
        if (p.cells > 1)
            p.cells--;
        else
            p.depth--;
        count(solution, &p, NULL);
    }
    return p;
}

/* Channels that are shown as red, green and blue; false: their mean, as grey. */
static bool find_rgb(const hpr_solution *solution, size_t channel[3])
{
    static const char *const names[] = {"R", "G", "B"};
    int found = 0;
    for (int k = 0; k < 3; k++) {
        for (size_t c = 0; c < solution->channel_count; c++) {
            if (!strcmp(solution->channel_name[c], names[k])) {
                channel[k] = c;
                found |= 1 << k;
            }
        }
    }
    return found == 7;
}

typedef struct shading {
    const hpr_solution *solution;
    hpr_reconstruction reconstruction;
    bool rgb;
    size_t channel[3];
    double *irradiance; /* [channels] scratch */
} shading;

/* Radiance of the patch at x(s,t) as three colours. */
static void shade(const shading *how, size_t patch, double s, double t, float colour[3])
{
    const hpr_solution *solution = how->solution;
    size_t n = solution->channel_count;
    hpr_reconstruct_point(&how->reconstruction, patch, s, t, how->irradiance);
    double sum = 0;
    for (size_t c = 0; c < n; c++) {
        double *value = how->irradiance + c;
        *value = (solution->patches->exitance[patch * n + c] +
                  solution->patches->reflectance[patch * n + c] * *value) /
                 pi;
        sum += *value;
    }
    for (int k = 0; k < 3; k++)
        colour[k] = (float)(how->rgb ? how->irradiance[how->channel[k]] : sum / (double)n);
}

static void place_vertex(const shading *how, hpr_solution_mesh *mesh, uint32_t node, double s, double t,
                         size_t vertex)
{
    const hpr_elements *e = how->solution->elements;
    uint32_t patch = e->patch[node];
    hpr_shape shape = (hpr_shape)how->solution->patches->shape[patch];
    const double *opposite = e->opposite + 2 * (size_t)node;
    double middle[2];
    if (shape == HPR_SHAPE_QUADRILATERAL) { /* the bilinear map */
        double both = s * t;
        s += both * (opposite[0] - 1);
        t += both * (opposite[1] - 1);
    }
    hpr_shape_middle(shape, opposite, middle);
    /* the colour is taken a hair inside: on the border another element might answer */
    double inner_s = s + 1e-6 * (middle[0] - s), inner_t = t + 1e-6 * (middle[1] - t);
    double inner[3], patch_s, patch_t;
    for (int k = 0; k < 3; k++) {
        double o = e->origin[3 * node + k], a = e->edge1[3 * node + k], b = e->edge2[3 * node + k];
        mesh->position[3 * vertex + k] = (float)(o + s * a + t * b - mesh->centre[k]);
        inner[k] = o + inner_s * a + inner_t * b;
    }
    hpr_patch_parameters(how->solution->patches, patch, inner, &patch_s, &patch_t);
    shade(how, patch, patch_s, patch_t, mesh->colour + 3 * vertex);
}

static void fill_piece(const shading *how, hpr_solution_mesh *mesh, const piece *it)
{
    bool triangle = is_triangle(how->solution, it->node);
    size_t vertex = it->first_vertex;
    uint32_t *index = mesh->index + it->first_index;
    uint32_t row = (uint32_t)vertex;
    for (uint32_t j = 0; j <= it->cells; j++) {
        uint32_t columns = triangle ? it->cells - j : it->cells; /* cells in this row of vertices */
        for (uint32_t i = 0; i <= columns; i++)
            place_vertex(how, mesh, it->node, (double)i / it->cells, (double)j / it->cells, vertex++);
        uint32_t above = row + columns + 1;
        for (uint32_t i = 0; j < it->cells && i < columns; i++) {
            const uint32_t corners[6] = {row + i,     row + i + 1,   above + i,
                                         row + i + 1, above + i + 1, above + i};
            size_t used = triangle && i + 1 == columns ? 3 : 6;
            memcpy(index, corners, used * sizeof *index);
            index += used;
        }
        row = above;
    }
}

static double luminance(const float colour[3])
{
    return 0.2126 * (double)colour[0] + 0.7152 * (double)colour[1] + 0.0722 * (double)colour[2];
}

/* 0.18 over the log-average luminance; what is a million times darker than the brightest counts as black. */
static double auto_exposure(const hpr_solution *solution, const hpr_solution_mesh *mesh, const piece *pieces,
                            size_t piece_count)
{
    double largest = 0, weight = 0, sum = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++)
        largest = fmax(largest, luminance(mesh->colour + 3 * v));
    for (size_t i = 0; i < piece_count; i++) {
        size_t end = i + 1 < piece_count ? pieces[i + 1].first_vertex : mesh->vertex_count;
        double share = solution->elements->area_m2[pieces[i].node] / (double)(end - pieces[i].first_vertex);
        for (size_t v = pieces[i].first_vertex; v < end; v++) {
            double value = luminance(mesh->colour + 3 * v);
            if (value > 1e-6 * largest) {
                weight += share;
                sum += share * log(value);
            }
        }
    }
    double exposure = weight > 0 ? 0.18 / exp(sum / weight) : 1;
    return isfinite(exposure) && exposure > 0 ? exposure : 1;
}

static void apply_exposure(hpr_solution_mesh *mesh)
{
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++) {
        double value = (double)mesh->colour[i] * mesh->exposure;
        mesh->colour[i] = value > 0 ? (float)fmin(value, 1) : 0; /* no number: black */
    }
}

static void measure(hpr_solution_mesh *mesh)
{
    for (int k = 0; k < 3; k++) {
        mesh->low[k] = mesh->high[k] = mesh->vertex_count ? mesh->position[k] : 0;
        for (size_t v = 0; v < mesh->vertex_count; v++) {
            mesh->low[k] = fminf(mesh->low[k], mesh->position[3 * v + (size_t)k]);
            mesh->high[k] = fmaxf(mesh->high[k], mesh->position[3 * v + (size_t)k]);
        }
    }
}

hpr_status hpr_solution_mesh_init(const hpr_solution *solution, hpr_solution_mesh *mesh)
{
    hpr_context *ctx = solution->context;
    *mesh = (hpr_solution_mesh){.context = ctx, .exposure = 1};
    mesh->radius = hpr_patches_radius(solution->patches, mesh->centre);
    plan p = choose(solution);
    if (p.vertex_count >= UINT32_MAX)
        return hpr_fail(ctx, HPR_ERR_UNSUPPORTED, "a .glb cannot hold the mesh of %zu patches",
                        solution->patches->count);
    piece *pieces = NULL;
    shading how = {.solution = solution};
    how.rgb = find_rgb(solution, how.channel);
    hpr_status status = hpr_allocate_into(ctx, &pieces, p.node_count, sizeof *pieces, "a mesh");
    if (status == HPR_OK)
        status = hpr_reconstruction_init(solution, &how.reconstruction);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &how.irradiance, solution->channel_count, sizeof(double), "a mesh");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &mesh->position, p.vertex_count, 3 * sizeof(float), "a mesh");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &mesh->colour, p.vertex_count, 3 * sizeof(float), "a mesh");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &mesh->index, p.index_count, sizeof(uint32_t), "a mesh");
    if (status == HPR_OK) {
        count(solution, &p, pieces);
        mesh->vertex_count = p.vertex_count;
        mesh->index_count = p.index_count;
        for (size_t i = 0; i < p.node_count; i++)
            fill_piece(&how, mesh, pieces + i);
        mesh->exposure = auto_exposure(solution, mesh, pieces, p.node_count);
        apply_exposure(mesh);
        measure(mesh);
    }
    hpr_release(ctx, pieces);
    hpr_release(ctx, how.irradiance);
    hpr_reconstruction_fini(&how.reconstruction);
    return status;
}

void hpr_solution_mesh_fini(hpr_solution_mesh *mesh)
{
    hpr_release(mesh->context, mesh->position);
    hpr_release(mesh->context, mesh->colour);
    hpr_release(mesh->context, mesh->index);
    *mesh = (hpr_solution_mesh){0};
}
