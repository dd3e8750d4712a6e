#include "link/afford.h"

#include "math/hash.h"
#include "visibility/views.h"

#include <math.h>

static size_t draw(uint64_t seed, size_t count)
{
    return (size_t)(hpr_hash(seed * HPR_HASH_STEP) % count);
}

typedef struct prediction {
    double links, blocks; /* pairs of patches that are linked, doubles in their blocks */
} prediction;

/* Of the block of a pair of patches: all of an element's, if it is the patch; where it is divided, links may
 * be as small as a constant. */
static size_t least_dofs(const hpr_elements *elements, size_t patch)
{
    size_t first = elements->patch_leaf[patch], end = elements->patch_leaf[patch + 1];
    return end - first == 1 ? elements->dof[end] - elements->dof[first] : 1;
}

/* Both at the lower end of two standard errors. */
static prediction predict(const hpr_visibility *visibility, const hpr_elements *elements)
{
    enum { MOST_DRAWN = 20000, ENOUGH = 200 }; /* one that faces takes a look at all occluders */
    const hpr_patches *patches = hpr_visibility_patches(visibility);
    double n = (double)patches->count, drawn = 0, seen = 0, size = 0, square = 0;
    for (uint64_t k = 0; k < MOST_DRAWN && seen < ENOUGH; k++) {
        size_t i = draw(2 * k + 1, patches->count), j = draw(2 * k + 2, patches->count);
        hpr_facet a = hpr_patch_facet(patches, i), b = hpr_patch_facet(patches, j);
        drawn++;
        if (i == j || hpr_visibility_classify(visibility, &a, &b, NULL, 0, NULL, NULL) == HPR_SEES_NOTHING)
            continue;
        double block = (double)least_dofs(elements, i) * (double)least_dofs(elements, j);
        seen++;
        size += block;
        square += block * block;
    }
    double part = seen / drawn, mean = size / drawn;
    part -= 2 * sqrt(part * (1 - part) / drawn);
    mean -= 2 * sqrt(fmax(square / drawn - mean * mean, 0) / drawn);
    return (prediction){fmax(part, 0) * n * n / 2, fmax(mean, 0) * n * n / 2};
}

double hpr_links_predict(const hpr_visibility *visibility, const hpr_elements *elements)
{
    static const double bytes_per_link = 40;
    double pairs = pow((double)hpr_visibility_patches(visibility)->count, 2);
    prediction expected = predict(visibility, elements);
    return pairs + expected.links * bytes_per_link + expected.blocks * sizeof(double);
}

double hpr_links_most_bytes(double asked)
{
    return asked > 0 ? asked : 0.5 * hpr_machine_bytes();
}

hpr_status hpr_links_afford(const hpr_visibility *visibility, const hpr_elements *elements, double asked)
{
    enum { FEW_PATCHES = 2000 }; /* classified in a moment, and then the size is known */
    const hpr_patches *patches = hpr_visibility_patches(visibility);
    if (patches->count <= FEW_PATCHES)
        return HPR_OK;
    double most = hpr_links_most_bytes(asked);
    double needed = hpr_links_predict(visibility, elements);
    size_t dofs = elements->dof[elements->leaf_count];
    if (needed > most)
        return hpr_fail(
            patches->context, HPR_ERR_MEMORY,
            "%zu patches with %zu coefficients need about %.3g GB for the blocks between them, more "
            "than %.3g GB (--max-memory): take %s",
            patches->count, dofs, 1e-9 * needed, 1e-9 * most,
            dofs > patches->count ? "a lower --subdivide or --order" : "a simpler scene");
    return HPR_OK;
}
