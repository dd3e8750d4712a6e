/* Lambert's formula beside a polygon: against 60-digit sums of the plain formula. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

#include <cmocka.h>

#include "direct/lambert.h"

typedef struct seen {
    double x, y, height, tilt[2], fraction; /* tilt: x and y of the normal (tilt, -1), not yet of length 1 */
} seen;

/* The unit square in z = 0, normal up. */
static const seen cases[] = {
    {1.5, 0.25, 0x1p-30, {0, 0}, 4.7753199264938648541e-19},
    {1 + 0x1p-20, 0.5, 0x1p-30, {0, 0}, 2.3841840857049000539e-7},
    {-0.5, 0.25, 0x1p-10, {0, 0}, 5.2504991629061323022e-7},
    {1.5, 0.25, 0x1p-20, {-3 * 0x1p-20, 0}, 1.574930644534807755e-12},
    {2, 1, 0x1p-30, {0, 0}, 5.8512798844388418787e-20}, /* on the line of an edge */
    {1, 0.25, 0x1p-30, {0, 0}, 0.49999999999999999799}, /* over an edge */
    {0.5, 0.5, 0x1p-30, {0, 0}, 0.99999999999999999716},
    {1.5, 0.25, 0.5, {-0.5, 0.25}, 0.10469181640740336577},
};

static const double bound = 1e-14; /* worst seen: 1.4e-15 */

static hpr_lambert evaluate(const seen *c, bool turned_over)
{
    static const double square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    hpr_vec3 normal = {c->tilt[0], c->tilt[1], -1}, corner[4];
    normal = hpr_scale(normal, 1 / hpr_length(normal));
    for (int i = 0; i < 4; i++) {
        const double *at = square[turned_over ? 3 - i : i];
        corner[i] = (hpr_vec3){at[0] - c->x, at[1] - c->y, -c->height};
    }
    return hpr_lambert_beside(normal, (hpr_vec3){0, 0, 1}, c->height, corner, 4);
}

static void nothing_cancels_beside_a_polygon(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int turned = 0; turned < 2; turned++) {
            hpr_lambert got = evaluate(&cases[i], turned);
            double error = fabs(got.fraction / cases[i].fraction - 1);
            if (!(error <= bound))
                fail_msg("case %zu, turned over %d: %.17g, relative error %g, bound %g", i, turned,
                         got.fraction, error, bound);
            if (!(got.rounding < 64))
                fail_msg("case %zu: rounding told as %g", i, got.rounding);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(nothing_cancels_beside_a_polygon)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
