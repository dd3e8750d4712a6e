#include "path_estimate.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

typedef struct vec {
    double x, y, z;
} vec;

/* x = origin + a edge1 + b edge2, a, b >= 0, a + b <= 1; a = along1 . x - at1, b = along2 . x - at2. */
typedef struct triangle {
    vec origin, edge1, edge2, normal, along1, along2;
    double height, at1, at2; /* height = normal . origin */
    double area, pdf;        /* of choosing a point of it as light, per m2 */
    double reflectance[PATH_CHANNELS], exitance[PATH_CHANNELS];
    bool double_sided;
} triangle;

struct path_scene {
    size_t channels, count, emitter_count;
    double size;
    triangle *triangle; /* [count] */
    double *cumulated;  /* [emitter_count] chance of choosing an emitter up to this one */
    size_t *emitter;    /* [emitter_count] */
};

static vec sub(vec a, vec b)
{
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static vec madd(vec a, double f, vec b)
{
    return (vec){a.x + f * b.x, a.y + f * b.y, a.z + f * b.z};
}

static vec scale(double f, vec a)
{
    return (vec){f * a.x, f * a.y, f * a.z};
}

static double dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vec load(const double p[3])
{
    return (vec){p[0], p[1], p[2]};
}

/* splitmix64 (Steele, Lea & Flood 2014) */
static uint64_t next_bits(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static double next_unit(uint64_t *state)
{
    return (double)(next_bits(state) >> 11) * 0x1p-53;
}

static void add_triangle(path_scene *out, const hpr_scene *scene, size_t face, const uint32_t v[3])
{
    size_t n = scene->channel_count;
    uint32_t material = scene->mesh_material[scene->face_mesh[face]];
    vec p = load(scene->position + 3 * (size_t)v[0]);
    triangle t = {.origin = p};
    t.edge1 = sub(load(scene->position + 3 * (size_t)v[1]), p);
    t.edge2 = sub(load(scene->position + 3 * (size_t)v[2]), p);
    vec across = cross(t.edge1, t.edge2);
    double length2 = dot(across, across);
    if (!(length2 > 0))
        return;
    t.area = sqrt(length2) / 2;
    t.normal = scale(1 / sqrt(length2), across);
    t.along1 = scale(1 / length2, cross(t.edge2, across));
    t.along2 = scale(1 / length2, cross(across, t.edge1));
    t.height = dot(t.normal, p);
    t.at1 = dot(t.along1, p);
    t.at2 = dot(t.along2, p);
    t.double_sided = material != HPR_NONE && scene->material[material].double_sided;
    for (size_t c = 0; c < n; c++) {
        t.reflectance[c] = scene->face_reflectance[n * face + c];
        t.exitance[c] = material == HPR_NONE ? 0 : PI * scene->material_radiance[n * material + c];
    }
    out->triangle[out->count++] = t;
}

static double strongest(const double value[PATH_CHANNELS])
{
    return fmax(fmax(value[0], value[1]), value[2]);
}

static void list_emitters(path_scene *out)
{
    double total = 0;
    for (size_t i = 0; i < out->count; i++)
        total += out->triangle[i].area * strongest(out->triangle[i].exitance);
    double sum = 0;
    for (size_t i = 0; i < out->count; i++) {
        triangle *t = &out->triangle[i];
        double power = t->area * strongest(t->exitance);
        if (!(power > 0))
            continue;
        t->pdf = strongest(t->exitance) / total;
        sum += power / total;
        out->emitter[out->emitter_count] = i;
        out->cumulated[out->emitter_count++] = sum;
    }
}

path_scene *path_scene_create(const hpr_scene *scene)
{
    if (scene->channel_count > PATH_CHANNELS)
        return NULL;
    path_scene *out = calloc(1, sizeof *out);
    if (!out)
        return NULL;
    out->channels = scene->channel_count;
    out->triangle = calloc(2 * scene->face_count + 1, sizeof *out->triangle);
    out->emitter = calloc(2 * scene->face_count + 1, sizeof *out->emitter);
    out->cumulated = calloc(2 * scene->face_count + 1, sizeof *out->cumulated);
    if (!out->triangle || !out->emitter || !out->cumulated) {
        path_scene_destroy(out);
        return NULL;
    }
    for (size_t f = 0; f < scene->face_count; f++) {
        const uint32_t *v = scene->face_vertex + 4 * f;
        add_triangle(out, scene, f, v);
        if (v[3] != HPR_NONE)
            add_triangle(out, scene, f, (uint32_t[]){v[0], v[2], v[3]});
        for (int k = 0; k < 3 + (v[3] != HPR_NONE); k++) {
            for (int a = 0; a < 3; a++)
                out->size = fmax(out->size, fabs(scene->position[3 * (size_t)v[k] + (size_t)a]));
        }
    }
    list_emitters(out);
    return out;
}

void path_scene_destroy(path_scene *scene)
{
    if (!scene)
        return;
    free(scene->triangle);
    free(scene->emitter);
    free(scene->cumulated);
    free(scene);
}

/* Where origin + t direction meets the triangle, t in (low, high); else a negative number. */
static double meet(const triangle *t, vec origin, vec direction, double low, double high)
{
    double along = (t->height - dot(t->normal, origin)) / dot(t->normal, direction);
    if (!(along > low && along < high))
        return -1;
    vec x = madd(origin, along, direction);
    double a = dot(t->along1, x) - t->at1, b = dot(t->along2, x) - t->at2;
    return a >= 0 && b >= 0 && a + b <= 1 ? along : -1;
}

static const triangle *first_hit(const path_scene *scene, vec origin, vec direction, double *distance)
{
    const triangle *best = NULL;
    double nearest = INFINITY;
    for (size_t i = 0; i < scene->count; i++) {
        double t = meet(&scene->triangle[i], origin, direction, 1e-9 * scene->size, nearest);
        if (t > 0) {
            best = &scene->triangle[i];
            nearest = t;
        }
    }
    *distance = nearest;
    return best;
}

static bool blocked(const path_scene *scene, vec x, vec y, const triangle *target)
{
    vec across = sub(y, x);
    double low = 1e-9 * scene->size / sqrt(dot(across, across));
    for (size_t i = 0; i < scene->count; i++) {
        if (&scene->triangle[i] != target && meet(&scene->triangle[i], x, across, low, 1 - low) > 0)
            return true;
    }
    return false;
}

/* A direction about the normal with density cos / pi (Malley). */
static vec cosine_direction(vec normal, double u, double v)
{
    vec aside = fabs(normal.x) < 0.6 ? (vec){1, 0, 0} : (vec){0, 1, 0};
    vec first = cross(normal, aside);
    first = scale(1 / sqrt(dot(first, first)), first);
    vec second = cross(normal, first);
    double radius = sqrt(u), angle = 2 * PI * v;
    return madd(madd(scale(sqrt(1 - u), normal), radius * cos(angle), first), radius * sin(angle), second);
}

/* cos cos' / (pi r2), which is also the density per area of y when the direction at x is cosine-weighted; 0
 * where y shows a black back. */
static double geometry(vec x, vec normal, vec y, const triangle *at_y)
{
    vec across = sub(y, x);
    double r2 = dot(across, across), from = dot(normal, across), to = -dot(at_y->normal, across);
    if (at_y->double_sided)
        to = fabs(to);
    return from > 0 && to > 0 ? from * to / (PI * r2 * r2) : 0;
}

typedef struct vertex {
    vec point, normal;
    double throughput[PATH_CHANNELS];
} vertex;

/* Adds the light of one point on the emitters. u chooses the emitter, v and w the point. */
static void add_light(const path_scene *scene, const vertex *at, double u, double v, double w, double *sum)
{
    size_t e = 0;
    while (e + 1 < scene->emitter_count && u >= scene->cumulated[e])
        e++;
    const triangle *t = &scene->triangle[scene->emitter[e]];
    double root = sqrt(v);
    vec y = madd(madd(t->origin, root * (1 - w), t->edge1), root * w, t->edge2);
    double g = geometry(at->point, at->normal, y, t);
    if (!(g > 0) || blocked(scene, at->point, y, t))
        return;
    for (size_t c = 0; c < scene->channels; c++)
        sum[c] += at->throughput[c] * t->exitance[c] * g / (t->pdf + g);
}

/* Goes on to what is seen in the direction, adds its light, and makes it the next vertex; false at the end of
 * the path. */
static bool go_on(const path_scene *scene, vertex *at, vec direction, double *sum)
{
    double distance;
    const triangle *t = first_hit(scene, at->point, direction, &distance);
    if (!t)
        return false;
    bool back = dot(t->normal, direction) > 0;
    if (back && !t->double_sided)
        return false;
    vec y = madd(at->point, distance, direction);
    double g = geometry(at->point, at->normal, y, t);
    for (size_t c = 0; c < scene->channels; c++) {
        if (g > 0)
            sum[c] += at->throughput[c] * t->exitance[c] * g / (t->pdf + g);
        at->throughput[c] *= t->reflectance[c];
    }
    at->point = y;
    at->normal = back ? scale(-1, t->normal) : t->normal;
    return strongest(at->throughput) > 0;
}

/* Russian roulette: true if the path goes on. */
static bool survives(vertex *at, uint64_t *state)
{
    double chance = fmin(1, strongest(at->throughput));
    if (next_unit(state) >= chance)
        return false;
    for (int c = 0; c < PATH_CHANNELS; c++)
        at->throughput[c] /= chance;
    return true;
}

static void trace_path(const path_scene *scene, vertex at, const double strata[4], uint64_t *state,
                       double *sum)
{
    enum { ROULETTE_FROM = 4, LONGEST = 100000 };
    add_light(scene, &at, next_unit(state), strata[0], strata[1], sum);
    bool alive = go_on(scene, &at, cosine_direction(at.normal, strata[2], strata[3]), sum);
    for (int depth = 1; alive && depth < LONGEST; depth++) {
        if (depth >= ROULETTE_FROM && !survives(&at, state))
            return;
        double u = next_unit(state), v = next_unit(state), w = next_unit(state);
        add_light(scene, &at, u, v, w, sum);
        u = next_unit(state);
        v = next_unit(state);
        alive = go_on(scene, &at, cosine_direction(at.normal, u, v), sum);
    }
}

void path_estimate(const path_scene *scene, const double point[3], const double normal[3], size_t side,
                   uint64_t seed, path_result *result)
{
    size_t count = side * side;
    double total[PATH_CHANNELS] = {0}, squares[PATH_CHANNELS] = {0};
    *result = (path_result){0};
    if (scene->emitter_count == 0)
        return;
    for (size_t i = 0; i < count; i++) {
        uint64_t state = seed * 0xd6e8feb86659fd93u + i;
        next_bits(&state);
        /* Each stratum of the light goes with one of the directions: (row, column) -> (column, row + column).
         */
        size_t row = i / side, column = i % side, stratum[4] = {column, (row + column) % side, row, column};
        double strata[4];
        for (int k = 0; k < 4; k++)
            strata[k] = ((double)stratum[k] + next_unit(&state)) / (double)side;
        double sum[PATH_CHANNELS] = {0};
        vertex start = {load(point), load(normal), {1, 1, 1}};
        trace_path(scene, start, strata, &state, sum);
        for (size_t c = 0; c < scene->channels; c++) {
            total[c] += sum[c];
            squares[c] += sum[c] * sum[c];
        }
    }
    for (size_t c = 0; c < scene->channels; c++) {
        double mean = total[c] / (double)count, variance = squares[c] / (double)count - mean * mean;
        result->mean[c] = mean;
        result->error[c] = sqrt(fmax(variance, 0) / (double)(count > 1 ? count - 1 : 1));
    }
}
