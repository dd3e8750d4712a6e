/* Unit cubes with faces of different reflectance and exitance; mean radiosity of each, 9 digits (open.json).
 */
#ifndef HPR_TESTS_MIXED_CUBES_H
#define HPR_TESTS_MIXED_CUBES_H

typedef struct mixed {
    const char *name;
    double reflectance[6], exitance[6], mean[6];
    int open; /* face that is missing, -1: none */
} mixed;

/* Faces x0, x1, y0, y1, z0, z1. */
static const mixed mixed_cubes[] = {
    {"cube_mixed",
     {0.2, 0.7, 0.5, 0.5, 0.8, 0.6},
     {0, 0, 0, 0, 0, 1},
     {0.08180636626798, 0.2691067219769, 0.1964938830281, 0.1964938830281, 0.2856397804044, 1.139568057221},
     -1},
    {"cube_mixed2",
     {0.9, 0.3, 0.6, 0.4, 0.5, 0.1},
     {0.1, 0.5, 0, 0, 0.25, 1},
     {0.6207102205998, 0.6714525496046, 0.3773383244274, 0.2587590859209, 0.5412218399525, 1.051240889777},
     -1},
    {"cube_highrho",
     {0.95, 0.95, 0.95, 0.95, 0.95, 0.95},
     {0, 0, 0, 0, 1, 0},
     {3.190787518142, 3.190787518142, 3.190787518142, 3.190787518142, 4.086258673657, 3.150591253774},
     -1},
    {"box_open5",
     {0.5, 0.5, 0.5, 0.5, 0.5, 0.0},
     {0, 0, 0, 0, 1, 0},
     {0.1530340592997, 0.1530340592997, 0.1530340592997, 0.1530340592997, 1.077514590206, 0},
     5},
};
enum { MIXED_CUBES = sizeof mixed_cubes / sizeof *mixed_cubes };

#endif
