#include "app/study_grid.h"

#include <math.h>
#include <string.h>

typedef struct list {
    size_t count;
    hpr_study_run *run;
} list;

static void add(list *l, const hpr_study_run *run)
{
    for (size_t i = 0; i < l->count; i++) {
        const hpr_study_run *other = &l->run[i];
        if (run->method == other->method && run->direct == other->direct && run->order == other->order &&
            run->subdivide == other->subdivide && run->grade == other->grade &&
            run->tolerance == other->tolerance && run->adapt == other->adapt)
            return;
    }
    l->run[l->count++] = *run;
}

/* One order: on all subdivisions, on the first, and graded. */
static void add_order(list *l, const hpr_job_study_options *o, hpr_study_run run)
{
    run.grade = o->solve.grade;
    for (size_t k = 0; k < o->subdivide_count; k++) {
        run.subdivide = o->subdivide[k];
        if ((o->refine & HPR_STUDY_H) || (k == 0 && (o->refine & HPR_STUDY_P)))
            add(l, &run);
    }
    run.subdivide = o->subdivide[0];
    run.grade = run.order;
    if ((o->refine & HPR_STUDY_HP) && run.method == HPR_METHOD_GALERKIN)
        add(l, &run);
}

static void add_adaptive(list *l, const hpr_job_study_options *o, hpr_study_run run)
{
    static const struct {
        hpr_study_way way;
        hpr_refine_mode mode;
    } ways[] = {{HPR_STUDY_H, HPR_REFINE_H}, {HPR_STUDY_P, HPR_REFINE_P}, {HPR_STUDY_HP, HPR_REFINE_HP}};
    int adapt = run.method == HPR_METHOD_HIERARCHICAL ? HPR_STUDY_H : o->adapt; /* constants stay constants */
    run.order = run.subdivide = HPR_CHOOSE;
    run.grade = o->solve.grade;
    for (int w = 0; w < 3; w++) {
        run.adapt = ways[w].mode;
        for (size_t t = 0; (adapt & ways[w].way) && t < o->tolerance_count; t++) {
            run.tolerance = o->tolerance[t];
            add(l, &run);
        }
    }
}

static bool can_adapt(hpr_method method)
{
    return method <= HPR_METHOD_HIERARCHICAL;
}

static hpr_status check_tolerances(hpr_context *ctx, const hpr_job_study_options *o)
{
    bool adapts = false;
    for (size_t m = 0; m < o->method_count; m++)
        adapts = adapts || can_adapt(o->method[m]);
    if (o->tolerance_count && !(adapts && o->adapt))
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "tolerances are of methods galerkin and hierarchical, and need a refinement");
    for (size_t t = 0; t < o->tolerance_count; t++) {
        if (!(o->tolerance[t] > 0 && o->tolerance[t] < 1))
            return hpr_fail(ctx, HPR_ERR_ARG, "tolerance %g is not in (0, 1)", o->tolerance[t]);
    }
    return HPR_OK;
}

hpr_status hpr_study_plan(hpr_context *ctx, const hpr_job_study_options *o, size_t *count,
                          hpr_study_run **run)
{
    *run = NULL;
    *count = 0;
    if (!o->order_count || !o->subdivide_count || !o->method_count || !o->direct_count || !o->refine)
        return hpr_fail(ctx, HPR_ERR_ARG, "a study needs orders, subdivisions, methods and a refinement");
    hpr_status status = check_tolerances(ctx, o);
    if (status != HPR_OK)
        return status;
    list l = {0};
    size_t uniform = o->order_count * (o->subdivide_count + 1), adaptive = 3 * o->tolerance_count;
    size_t most = o->method_count * o->direct_count * (uniform + adaptive);
    status = hpr_allocate_into(ctx, &l.run, most, sizeof *l.run, "a study");
    if (status != HPR_OK)
        return status;
    for (size_t m = 0; m < o->method_count; m++) {
        bool galerkin = o->method[m] == HPR_METHOD_GALERKIN;
        for (size_t d = 0; d < (galerkin ? o->direct_count : 1); d++) {
            for (size_t p = 0; p < (galerkin ? o->order_count : 1); p++)
                add_order(&l, o,
                          (hpr_study_run){.method = o->method[m],
                                          .direct = galerkin ? o->direct[d] : HPR_DIRECT_GALERKIN,
                                          .order = galerkin ? o->order[p] : 0});
            if (can_adapt(o->method[m]))
                add_adaptive(&l, o,
                             (hpr_study_run){.method = o->method[m],
                                             .direct = galerkin ? o->direct[d] : HPR_DIRECT_GALERKIN});
        }
    }
    *run = l.run;
    *count = l.count;
    return HPR_OK;
}

double hpr_study_weight(const hpr_study_run *run)
{
    static const double adaptive = 2; /* coefficients per patch of the Cornell box, times the tolerance */
    double functions = (run->order + 1.0) * (run->order + 1.0);
    double count = run->tolerance > 0 ? adaptive / run->tolerance
                                      : functions * ldexp(1, 2 * run->subdivide) * (1 + run->grade);
    return 3000 + pow(count, 1.5);
}
