#include "patch/even.h"

#include "math/vec3.h"

#include <hprad/solve.h>
#include <math.h>

enum { MAX_HALVINGS = 2 * HPR_MAX_SUBDIVIDE };

typedef struct limit {
    const hpr_patches *patches;
    double longest_m;
} limit;

static bool longer(double length_m, double longest_m)
{
    static const double rounding = 1e-12; /* a side of 1/3 m is halved as one of 0.333... m is */
    return length_m > longest_m * (1 + rounding);
}

static int choose(void *user, const hpr_piece_of_leaf *piece)
{
    const limit *l = user;
    size_t p = 3 * (size_t)piece->patch;
    hpr_vec3 e1 = hpr_vec3_load(l->patches->edge1 + p), e2 = hpr_vec3_load(l->patches->edge2 + p);
    hpr_vec3 a = hpr_madd(hpr_scale(e1, piece->edge1[0]), piece->edge1[1], e2);
    hpr_vec3 b = hpr_madd(hpr_scale(e1, piece->edge2[0]), piece->edge2[1], e2);
    double along = hpr_length(a), across = hpr_length(b), longest = fmax(along, across);
    if (l->patches->shape[piece->patch] == HPR_SHAPE_TRIANGLE)
        longest = fmax(longest, hpr_length(hpr_sub(b, a)));
    if (piece->level >= MAX_HALVINGS || !longer(longest, l->longest_m))
        return -1;
    return along >= across ? 0 : 1;
}

hpr_status hpr_elements_even(const hpr_patches *patches, hpr_elements *elements, double longest_m)
{
    limit l = {patches, longest_m};
    if (!(longest_m > 0))
        return hpr_fail(patches->context, HPR_ERR_ARG, "elements cannot be %g m long", longest_m);
    return hpr_elements_refine(patches, elements, choose, &l);
}

static double longest_side(const hpr_patches *patches)
{
    double longest = 0;
    for (size_t i = 0; i < patches->count; i++) {
        hpr_vec3 a = hpr_vec3_load(patches->edge1 + 3 * i), b = hpr_vec3_load(patches->edge2 + 3 * i);
        longest = fmax(longest, fmax(hpr_length(a), hpr_length(b)));
        if (patches->shape[i] == HPR_SHAPE_TRIANGLE)
            longest = fmax(longest, hpr_length(hpr_sub(b, a)));
    }
    return longest;
}

hpr_status hpr_elements_even_within(const hpr_patches *patches, int order, size_t most_dofs,
                                    double *longest_m)
{
    enum { STEPS_PER_OCTAVE = 8 };
    hpr_elements *trial = NULL;
    hpr_status status = hpr_elements_uniform(patches, order, 0, &trial);
    double whole_m = longest_side(patches), next_m = whole_m;
    *longest_m = whole_m;
    for (int step = 1; status == HPR_OK && next_m > 0 && trial->dof[trial->leaf_count] <= most_dofs &&
                       step <= MAX_HALVINGS * STEPS_PER_OCTAVE;
         step++) {
        *longest_m = next_m;
        next_m = whole_m * exp2(-(double)step / STEPS_PER_OCTAVE);
        status = hpr_elements_even(patches, trial, next_m);
    }
    hpr_elements_destroy(&trial);
    return status;
}
