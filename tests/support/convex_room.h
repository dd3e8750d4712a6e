/* A closed convex room of triangles of very different sizes, slivers among them. */
#ifndef HPR_TESTS_CONVEX_ROOM_H
#define HPR_TESTS_CONVEX_ROOM_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { CONVEX_ROOM_FACES = 300 };

typedef struct convex_room {
    int count;
    double corner[CONVEX_ROOM_FACES + 1][3][3]; /* counter-clockwise from inside; the last is room to work */
} convex_room;

/* Uniform in [0, 1). Source: Steele, Lea & Flood 2014 (SplitMix64). */
static inline double convex_random(uint64_t *seed)
{
    uint64_t z = *seed += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

/* Six times the volume of the tetrahedron: above 0 if d is on the side that a, b, c turn towards. */
static inline double convex_side(const double *a, const double *b, const double *c, const double *d)
{
    double u[3], v[3], w[3];
    for (int k = 0; k < 3; k++) {
        u[k] = b[k] - a[k];
        v[k] = c[k] - a[k];
        w[k] = d[k] - a[k];
    }
    return (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] +
           (u[0] * v[1] - u[1] * v[0]) * w[2];
}

/* All triangles of the hull of a few points in general position: all others are on one side. */
static inline void convex_hull(int count, const double (*point)[3], convex_room *room)
{
    for (int i = 0; i < count; i++) {
        for (int j = i + 1; j < count; j++) {
            for (int k = j + 1; k < count; k++) {
                int above = 0, below = 0;
                for (int l = 0; l < count; l++) {
                    double side = convex_side(point[i], point[j], point[k], point[l]);
                    above += l != i && l != j && l != k && side > 0;
                    below += l != i && l != j && l != k && side < 0;
                }
                if (above && below)
                    continue;
                const int order[3] = {i, above ? j : k, above ? k : j};
                for (int c = 0; c < 3; c++)
                    memcpy(room->corner[room->count][c], point[order[c]], sizeof point[0]);
                room->count++;
            }
        }
    }
}

typedef struct convex_size {
    double longest, height, area; /* height over the longest edge */
} convex_size;

static inline convex_size convex_measure(const double (*corner)[3])
{
    convex_size size = {0, 0, 0};
    double e[3][3], cross = 0;
    for (int i = 0; i < 3; i++) {
        double length = 0;
        for (int k = 0; k < 3; k++) {
            e[i][k] = corner[(i + 1) % 3][k] - corner[i][k];
            length += e[i][k] * e[i][k];
        }
        size.longest = fmax(size.longest, sqrt(length));
    }
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        cross += pow(e[0][a] * e[1][b] - e[0][b] * e[1][a], 2);
    }
    size.area = sqrt(cross) / 2;
    size.height = 2 * size.area / size.longest;
    return size;
}

/* The triangle in two, at a part f of an edge, or in three, around a point of it. False if a part would be
 * too slender. */
static inline bool convex_split(convex_room *room, int which, uint64_t *seed)
{
    static const double part[] = {0.5, 0.3, 0.1, 0.02, 0.003}, slenderest = 1e-4, smallest = 3e-4;
    double old[3][3], made[3][3][3], middle[3], weight[3];
    memcpy(old, room->corner[which], sizeof old);
    double f = part[(int)(5 * convex_random(seed))];
    bool in_two = convex_random(seed) < 0.6;
    int edge = (int)(3 * convex_random(seed)), count = in_two ? 2 : 3;
    weight[edge] = in_two ? 0 : f * convex_random(seed);
    weight[(edge + 1) % 3] = f * (1 - weight[edge]);
    weight[(edge + 2) % 3] = (1 - f) * (1 - weight[edge]);
    for (int k = 0; k < 3; k++)
        middle[k] = weight[0] * old[0][k] + weight[1] * old[1][k] + weight[2] * old[2][k];
    for (int i = 0; i < count; i++) {
        /* the corners but the edge's opposite one, two by two; in three, all pairs */
        int first = (edge + i + (in_two ? 2 : 0)) % 3;
        memcpy(made[i][0], middle, sizeof middle);
        memcpy(made[i][1], old[first], sizeof middle);
        memcpy(made[i][2], old[(first + 1) % 3], sizeof middle);
        convex_size size = convex_measure((const double(*)[3])made[i]);
        if (size.height < slenderest * size.longest || size.longest < smallest)
            return false;
    }
    memcpy(room->corner[which], made[0], sizeof made[0]);
    for (int i = 1; i < count; i++)
        memcpy(room->corner[room->count++], made[i], sizeof made[i]);
    return true;
}

/* The hull of points on an ellipsoid, its triangles split unevenly. */
static inline void convex_room_make(convex_room *room, uint64_t seed)
{
    enum { POINTS = 14 };
    static const double half[3] = {1, 0.7, 0.5};
    double point[POINTS][3];
    for (int i = 0; i < POINTS; i++) {
        double z = 2 * convex_random(&seed) - 1, turn = 4 * acos(0) * convex_random(&seed);
        point[i][0] = half[0] * sqrt(1 - z * z) * cos(turn);
        point[i][1] = half[1] * sqrt(1 - z * z) * sin(turn);
        point[i][2] = half[2] * z;
    }
    room->count = 0;
    convex_hull(POINTS, (const double(*)[3])point, room);
    while (room->count <= CONVEX_ROOM_FACES - 2)
        convex_split(room, (int)(room->count * convex_random(&seed)), &seed);
    while (room->count < CONVEX_ROOM_FACES) { /* one is missing, and a split may make two */
        convex_room copy = *room;
        convex_split(&copy, (int)(copy.count * convex_random(&seed)), &seed);
        if (copy.count <= CONVEX_ROOM_FACES)
            *room = copy;
    }
}

#endif
