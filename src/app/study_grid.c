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
            run->subdivide == other->subdivide && run->grade == other->grade)
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

hpr_status hpr_study_plan(hpr_context *ctx, const hpr_job_study_options *o, size_t *count,
                          hpr_study_run **run)
{
    *run = NULL;
    *count = 0;
    if (!o->order_count || !o->subdivide_count || !o->method_count || !o->direct_count || !o->refine)
        return hpr_fail(ctx, HPR_ERR_ARG, "a study needs orders, subdivisions, methods and a refinement");
    list l = {0};
    size_t most = o->method_count * o->direct_count * o->order_count * (o->subdivide_count + 1);
    hpr_status status = hpr_allocate_into(ctx, &l.run, most, sizeof *l.run, "a study");
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
        }
    }
    *run = l.run;
    *count = l.count;
    return HPR_OK;
}

double hpr_study_weight(const hpr_study_run *run)
{
    double functions = (run->order + 1.0) * (run->order + 1.0);
    return 3000 + pow(functions * ldexp(1, 2 * run->subdivide) * (1 + run->grade), 1.5);
}
