/* Options of the classical methods. */
#include "cli/cli.h"

#include <limits.h>
#include <string.h>

const struct poptOption cli_method_options[] = {
    {"method", 0, POPT_ARG_STRING, NULL, CLI_OPTION_METHOD,
     "galerkin, hprad's own (default); hierarchical, constants on links; or constants and the full matrix of "
     "form factors, by hemicube, by raycast (discs), or exact, as hprad integrates them",
     "NAME"},
    {"hemicube", 0, POPT_ARG_STRING, NULL, CLI_OPTION_HEMICUBE,
     "pixels along an edge of the hemicube, an even number up to 4096 (default 256)", "N"},
    {"rays", 0, POPT_ARG_STRING, NULL, CLI_OPTION_RAYS,
     "of ray casting: N x N discs per sender, 1 to 64 (default 2)", "N"},
    {"shots", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SHOTS, "of shooting: end after N shots, converged or not",
     "N"},
    {"every", 0, POPT_ARG_STRING, NULL, CLI_OPTION_EVERY,
     "of shooting: after every N shots also write the solution so far, as NAME_000100.glb", "N"},
    POPT_TABLEEND};

static bool take_method(const char *text, hpr_method *method)
{
    for (int i = HPR_METHOD_GALERKIN; i <= HPR_METHOD_EXACT; i++) {
        *method = (hpr_method)i;
        if (!strcmp(text, hpr_method_name(*method)))
            return true;
    }
    cli_complain("--method '%s': expected galerkin, hierarchical, hemicube, raycast or exact", text);
    return false;
}

static bool take_hemicube(const char *text, int *pixels)
{
    if (!cli_integer("--hemicube", text, 2, HPR_MAX_HEMICUBE, pixels))
        return false;
    if (*pixels % 2 == 0)
        return true;
    cli_complain("--hemicube '%s': expected an even number", text);
    return false;
}

int cli_take_method_option(cli_method_settings *settings, hpr_solve_options *solve, int id, const char *value)
{
    hpr_baseline_options *baseline = &settings->baseline;
    switch (id) {
    case CLI_OPTION_METHOD:
        return take_method(value, &solve->method);
    case CLI_OPTION_HEMICUBE:
        settings->hemicube_given = true;
        return take_hemicube(value, &baseline->hemicube);
    case CLI_OPTION_RAYS:
        settings->rays_given = true;
        return cli_integer("--rays", value, 1, HPR_MAX_RAYS, &baseline->rays);
    case CLI_OPTION_SHOTS:
        return cli_integer("--shots", value, 1, INT_MAX, &baseline->shots);
    case CLI_OPTION_EVERY:
        return cli_integer("--every", value, 1, INT_MAX, &baseline->every);
    default:
        return -1;
    }
}

bool cli_check_method(const cli_method_settings *settings, const cli_solve_settings *solve)
{
    hpr_method method = solve->solve.method;
    bool classical = method > HPR_METHOD_HIERARCHICAL;
    bool shoots = classical && solve->solve.solver == HPR_SOLVER_SHOOTING;
    return cli_only_with("--hemicube", settings->hemicube_given, method == HPR_METHOD_HEMICUBE,
                         "--method hemicube") &&
           cli_only_with("--rays", settings->rays_given, method == HPR_METHOD_RAYCAST, "--method raycast") &&
           cli_only_with("--shots", settings->baseline.shots > 0, shoots,
                         "--solver shooting of a --method that has the full matrix") &&
           cli_only_with("--every", settings->baseline.every > 0, shoots,
                         "--solver shooting of a --method that has the full matrix") &&
           cli_only_with("--direct exact", solve->direct_given && solve->solve.direct == HPR_DIRECT_EXACT,
                         method == HPR_METHOD_GALERKIN, "--method galerkin");
}
