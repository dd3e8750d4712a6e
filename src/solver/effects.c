#include "solver/effects.h"

#include "solver/outside.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

static bool any_positive(const double *value, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (value[i] > 0)
            return true;
    }
    return false;
}

static double find_escaping(const hpr_solution *solution)
{
    double come_in = 0, escaped = 0;
    for (size_t c = 0; c < solution->channel_count; c++) {
        come_in += solution->energy[c].emitted + solution->energy[c].environment;
        escaped += solution->energy[c].escaped;
    }
    return come_in > 0 ? escaped / come_in : NAN;
}

hpr_effect_facts hpr_effect_facts_of(const hpr_solution *solution)
{
    const hpr_patches *patches = solution->patches;
    const hpr_solve_summary *summary = &solution->summary;
    size_t n = solution->channel_count;
    hpr_effect_facts facts = {.method = summary->options.method,
                              .patch_count = patches->count,
                              .channel_count = n,
                              .distinct_count = hpr_solution_distinct_channels(solution),
                              .texture_count = hpr_counter_value(solution->context, HPR_COUNT_TEXTURES),
                              .shines = hpr_outside_shines(solution),
                              .lamps_exact = summary->direct == HPR_DIRECT_EXACT,
                              .outside_exact = summary->environment == HPR_ENVIRONMENT_EXACT,
                              .occluded = summary->occluded,
                              .escaping = find_escaping(solution)};
    for (size_t i = 0; i < patches->count; i++) {
        facts.emitter_count += any_positive(patches->exitance + i * n, n);
        facts.reflector_count += any_positive(patches->reflectance + i * n, n);
        facts.two_sided_count += patches->side[i] == 1 && patches->twin[i] != HPR_NONE;
    }
    facts.interreflects = facts.reflector_count > 0 && summary->link_count > 0;
    facts.lit = facts.shines || facts.emitter_count > 0;
    return facts;
}

__attribute__((format(printf, 4, 5))) static void name_it(hpr_plan_effect *effect, const char *name,
                                                          bool called_for, const char *why, ...)
{
    va_list values;
    effect->name = name;
    effect->called_for = called_for;
    va_start(values, why);
    vsnprintf(effect->why, sizeof effect->why, why, values);
    va_end(values);
}

static void name_light(const hpr_effect_facts *f, hpr_plan_effect *channels, hpr_plan_effect *lamps,
                       hpr_plan_effect *environment)
{
    bool several = f->distinct_count > 1;
    name_it(channels, "channels", several,
            several ? "%zu that differ in light or reflectance" : "all %zu agree: one is solved for them",
            f->channel_count);
    if (!f->emitter_count)
        name_it(lamps, "lamps", false, "no patch emits");
    else
        name_it(lamps, "lamps", true, "%zu of %zu patches emit, %s", f->emitter_count, f->patch_count,
                f->lamps_exact ? "evaluated exactly at every point" : "through the basis");
    name_it(environment, "environment", f->shines,
            f->shines ? "light comes from outside" : "no light comes from outside");
}

static void name_transport(const hpr_effect_facts *f, hpr_plan_effect *visibility,
                           hpr_plan_effect *interreflection)
{
    bool classical = f->method > HPR_METHOD_HIERARCHICAL;
    bool between = f->lit && (f->occluded || classical);
    name_it(visibility, "visibility", between,
            !f->lit       ? "there is no light"
            : classical   ? "the full matrix looks for itself"
            : f->occluded ? "something may come between patches: those pairs are clipped, or sampled by rays"
                          : "nothing comes between patches that see each other: no ray, no clipping");
    bool reflects = f->lit && f->interreflects;
    if (reflects)
        name_it(interreflection, "interreflection", true, "%zu of %zu patches reflect", f->reflector_count,
                f->patch_count);
    else
        name_it(interreflection, "interreflection", false,
                !f->lit               ? "there is no light"
                : !f->reflector_count ? "nothing reflects: no kernel block, no iteration"
                                      : "nothing sees what reflects: no kernel block, no iteration");
}

void hpr_effects_name(const hpr_effect_facts *f, hpr_plan_effect effect[HPR_PLAN_EFFECTS])
{
    static const double closed = 1e-6; /* what is left of the light then is rounding and quadrature */
    name_light(f, &effect[0], &effect[1], &effect[2]);
    name_transport(f, &effect[3], &effect[4]);
    if (f->two_sided_count)
        name_it(&effect[5], "two_sided", true, "%zu surfaces are doubleSided, each side is a patch",
                f->two_sided_count);
    else
        name_it(&effect[5], "two_sided", false, "no surface is doubleSided: backs are black");
    if (f->texture_count)
        name_it(&effect[6], "textures", true, "%zu means over faces, of which patches take theirs",
                f->texture_count);
    else
        name_it(&effect[6], "textures", false, "no texture is sampled");
    bool open = !(fabs(f->escaping) <= closed); /* unknown: both must be expected */
    if (!open || isnan(f->escaping))
        name_it(&effect[7], "openings", open, open ? "there is no light to tell" : "closed: nothing leaves");
    else
        name_it(&effect[7], "openings", true, "open: a part of %.2g leaves", f->escaping);
}
