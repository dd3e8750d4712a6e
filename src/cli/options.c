/* Groups of options that several verbs have, and the strict reading of their values. */
#include "cli/cli.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* As the renderer has them; refused here before the solve and not after it. */
enum { MAX_PIXELS_PER_SIDE = 32768 };

const struct poptOption cli_solve_options[] = {
    {"order", 0, POPT_ARG_STRING, NULL, CLI_OPTION_ORDER, "polynomial degree of every element, 0 to 16", "P"},
    {"subdivide", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SUBDIVIDE,
     "N halvings per axis, 4^N elements per patch, 0 to 10", "N"},
    {"feet", 0, POPT_ARG_STRING, NULL, CLI_OPTION_FEET,
     "quarter elements that the foot of an object cuts, N times, each time one degree lower, 0 to 6 "
     "(default: 0 "
     "with --subdivide)",
     "N"},
    {"element-size", 0, POPT_ARG_STRING, NULL, CLI_OPTION_ELEMENT_SIZE,
     "halve elements across their longest side until none is longer than M metres (default: that is done "
     "where "
     "the patches are too many for --subdivide 2)",
     "M"},
    {"grade", 0, POPT_ARG_STRING, NULL, CLI_OPTION_GRADE,
     "halve elements toward edges at which patches meet, and toward their ends, N times, 0 to 20 (default 0)",
     "N"},
    {"tol", 0, POPT_ARG_STRING, NULL, CLI_OPTION_TOLERANCE,
     "relative L2 error of the irradiance: solve again on elements that are refined, from whole patches, "
     "until the estimated error is below E; --order and --subdivide then say what to begin with. Of galerkin "
     "and hierarchical",
     "E"},
    {"refine", 0, POPT_ARG_STRING, NULL, CLI_OPTION_REFINE,
     "with --tol: p, raise degrees; h, halve elements; hp, the one where the light is smooth and the other "
     "where it is not (default hp; hierarchical: h)",
     "WAY"},
    {"max-time", 0, POPT_ARG_STRING, NULL, CLI_OPTION_MAX_TIME,
     "with --tol: begin no refinement that would probably end later than S seconds after the first", "S"},
    {"max-memory", 0, POPT_ARG_STRING, NULL, CLI_OPTION_MAX_MEMORY,
     "refuse what needs more for kernel blocks, as 500M or 4G (default half of the machine's memory); "
     "with --tol: begin no refinement that would probably need more",
     "BYTES"},
    {"direct", 0, POPT_ARG_STRING, NULL, CLI_OPTION_DIRECT,
     "direct light: exact, evaluated at every point, or galerkin, through the basis (default exact)", "WAY"},
    {"environment", 0, POPT_ARG_STRING, NULL, CLI_OPTION_ENVIRONMENT,
     "uniform radiance from outside, W/m2/sr, seen by surfaces and cameras: one number, or one per channel, "
     "as R,G,B (default 0)",
     "L"},
    {"link-tol", 0, POPT_ARG_STRING, NULL, CLI_OPTION_LINK_TOLERANCE,
     "what links between groups of elements may leave out of the operator, relative to its norm (default: "
     "what the number of elements allows)",
     "T"},
    {"block-tol", 0, POPT_ARG_STRING, NULL, CLI_OPTION_BLOCK_TOLERANCE,
     "relative tolerance of each transport block (default 1e-13 where nothing blocks anything, else by what "
     "the blocked ones would cost)",
     "T"},
    {"solver", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SOLVER,
     "how the linear system is solved: gauss-seidel, gmres, gathering (Jacobi), shooting (progressive "
     "refinement), direct (elimination, of a full matrix only), or auto (default): Gauss-Seidel, and GMRES "
     "where that takes long",
     "NAME"},
    {"max-sweeps", 0, POPT_ARG_STRING, NULL, CLI_OPTION_MAX_SWEEPS, "iteration limit of the solver", "N"},
    {"max-reflectance", 0, POPT_ARG_STRING, NULL, CLI_OPTION_MAX_REFLECTANCE,
     "scale reflectances above R down to R", "R"},
    {"metallic", 0, POPT_ARG_STRING, NULL, CLI_OPTION_METALLIC,
     "how the metallic part of a material reflects: diffuse or black (default diffuse)", "WAY"},
    {"scene-index", 0, POPT_ARG_STRING, NULL, CLI_OPTION_SCENE_INDEX,
     "which scene of the file, from 0 (default: the file's choice)", "N"},
    {"report", 0, POPT_ARG_STRING, NULL, CLI_OPTION_REPORT, "write what was done and what it cost as JSON",
     "R.json"},
    POPT_TABLEEND};

const struct poptOption cli_common_options[] = {
    {"threads", 0, POPT_ARG_STRING, NULL, CLI_OPTION_THREADS,
     "worker threads (default OMP_NUM_THREADS, else the processors at hand); results do not depend on it",
     "N"},
    {"isa", 0, POPT_ARG_STRING, NULL, CLI_OPTION_ISA,
     "instruction set: auto, sse2, avx2 or avx512 (default auto)", "NAME"},
    {"quiet", 0, POPT_ARG_NONE, NULL, CLI_OPTION_QUIET, "no progress and no summary", NULL},
    {"verbose", 0, POPT_ARG_NONE, NULL, CLI_OPTION_VERBOSE, "say more on stderr", NULL},
    {"version", 0, POPT_ARG_NONE, NULL, CLI_OPTION_VERSION,
     "print version, commit, Embree version and instruction set", NULL},
    {"help", 0, POPT_ARG_NONE, NULL, CLI_OPTION_HELP, "print this", NULL},
    POPT_TABLEEND};

bool cli_integer(const char *option, const char *text, int low, int high, int *value)
{
    char *end;
    errno = 0;
    long number = strtol(text, &end, 10);
    bool begins = isdigit((unsigned char)text[0]) || text[0] == '-';
    if (!begins || *end || errno || number < low || number > high) {
        if (high == INT_MAX)
            cli_complain("%s '%s': expected a whole number from %d", option, text, low);
        else
            cli_complain("%s '%s': expected a whole number from %d to %d", option, text, low, high);
        return false;
    }
    *value = (int)number;
    return true;
}

bool cli_positive(const char *option, const char *text, double high, bool below, double *value)
{
    char *end;
    double number = strtod(text, &end);
    /* strtod also knows spaces, hexadecimals, inf and nan. */
    bool plain = text[0] && !text[strspn(text, "0123456789.+-eE")];
    if (!plain || *end || !isfinite(number) || number <= 0 || number > high || (below && number == high)) {
        if (isfinite(high))
            cli_complain("%s '%s': expected a number above 0 and %s %g", option, text,
                         below ? "below" : "up to", high);
        else
            cli_complain("%s '%s': expected a number above 0", option, text);
        return false;
    }
    *value = number;
    return true;
}

bool cli_size(const char *option, const char *text, int *width, int *height)
{
    int end = 0;
    bool plain = text[0] && !text[strspn(text, "0123456789x")];
    if (!plain || strlen(text) > 11 || sscanf(text, "%dx%d%n", width, height, &end) != 2 || text[end] ||
        *width < 1 || *width > MAX_PIXELS_PER_SIDE || *height < 1 || *height > MAX_PIXELS_PER_SIDE) {
        cli_complain("%s '%s': expected WIDTHxHEIGHT, each from 1 to %d, such as 640x480", option, text,
                     MAX_PIXELS_PER_SIDE);
        return false;
    }
    return true;
}

bool cli_take_environment(const char *text, cli_environment *environment)
{
    const char *rest = text;
    bool good = text[0] && !text[strspn(text, "0123456789.+-eE,")];
    environment->count = 0;
    while (good && environment->count < CLI_MAX_CHANNELS) {
        char *end;
        double value = strtod(rest, &end);
        good = end != rest && (*end == ',' || !*end) && isfinite(value) && value >= 0;
        environment->radiance[environment->count++] = value;
        rest = end;
        if (*rest != ',')
            break;
        rest++;
    }
    if (good && !*rest)
        return true;
    cli_complain("--environment '%s': expected a radiance from 0, or one per channel such as 1,1,0.8", text);
    return false;
}

static bool take_metallic(const char *text, int *black)
{
    *black = !strcmp(text, "black");
    if (*black || !strcmp(text, "diffuse"))
        return true;
    cli_complain("--metallic '%s': expected black or diffuse", text);
    return false;
}

static bool take_direct(const char *text, hpr_direct_mode *direct)
{
    *direct = !strcmp(text, "galerkin") ? HPR_DIRECT_GALERKIN : HPR_DIRECT_EXACT;
    if (*direct == HPR_DIRECT_GALERKIN || !strcmp(text, "exact"))
        return true;
    cli_complain("--direct '%s': expected exact or galerkin", text);
    return false;
}

static bool take_refine(const char *text, hpr_refine_mode *mode)
{
    for (int i = HPR_REFINE_HP; i <= HPR_REFINE_P; i++) {
        *mode = (hpr_refine_mode)i;
        if (!strcmp(text, hpr_refine_name(*mode)))
            return true;
    }
    cli_complain("--refine '%s': expected h, p or hp", text);
    return false;
}

/* A number of bytes, with K, M, G or T behind it for powers of 1000. */
static bool take_bytes(const char *option, const char *text, double *bytes)
{
    static const char units[] = "KMGT";
    char number[32];
    size_t length = strlen(text);
    const char *unit = length ? strchr(units, text[length - 1]) : NULL;
    snprintf(number, sizeof number, "%.*s", (int)(unit ? length - 1 : length), text);
    if (length >= sizeof number || !cli_positive(option, number, INFINITY, false, bytes))
        return false;
    *bytes *= unit ? pow(1000, (double)(unit - units + 1)) : 1;
    return true;
}

static bool take_solver(const char *text, hpr_solver_method *solver)
{
    for (int i = HPR_SOLVER_AUTO; i <= HPR_SOLVER_DIRECT; i++) {
        *solver = (hpr_solver_method)i;
        if (!strcmp(text, hpr_solver_name(*solver)))
            return true;
    }
    cli_complain("--solver '%s': expected auto, gauss-seidel, gmres, gathering, shooting or direct", text);
    return false;
}

bool cli_path(const char *option, const char *text, const char **path)
{
    *path = text;
    if (text[0])
        return true;
    cli_complain("%s '': expected a file name", option);
    return false;
}

bool cli_only_with(const char *option, bool given, bool fits, const char *what)
{
    if (given && !fits)
        cli_complain("%s has an effect only with %s", option, what);
    return !given || fits;
}

bool cli_check_solve(const cli_solve_settings *settings)
{
    const hpr_solve_options *solve = &settings->solve;
    bool adapts = solve->tolerance > 0;
    return cli_only_with("--refine", settings->refine_given, adapts, "--tol") &&
           cli_only_with("--max-time", solve->max_seconds > 0, adapts, "--tol") &&
           cli_only_with("--tol", adapts, solve->method <= HPR_METHOD_HIERARCHICAL,
                         "--method galerkin or hierarchical") &&
           cli_only_with("--refine", settings->refine_given && solve->refine != HPR_REFINE_H,
                         solve->method == HPR_METHOD_GALERKIN, "--method galerkin, but for h");
}

int cli_take_solve_option(cli_solve_settings *settings, int id, const char *value)
{
    hpr_solve_options *solve = &settings->solve;
    hpr_read_options *read = &settings->read;
    switch (id) {
    case CLI_OPTION_ORDER:
        return cli_integer("--order", value, 0, HPR_MAX_ORDER, &solve->order);
    case CLI_OPTION_SUBDIVIDE:
        if (!settings->feet_given)
            solve->feet = 0;
        return cli_integer("--subdivide", value, 0, HPR_MAX_SUBDIVIDE, &solve->subdivide);
    case CLI_OPTION_FEET:
        settings->feet_given = true;
        return cli_integer("--feet", value, 0, HPR_MAX_FEET, &solve->feet);
    case CLI_OPTION_ELEMENT_SIZE:
        return cli_positive("--element-size", value, INFINITY, false, &solve->element_size);
    case CLI_OPTION_GRADE:
        return cli_integer("--grade", value, 0, HPR_MAX_GRADE, &solve->grade);
    case CLI_OPTION_LINK_TOLERANCE:
        return cli_positive("--link-tol", value, 1, true, &solve->link_tolerance);
    case CLI_OPTION_BLOCK_TOLERANCE:
        return cli_positive("--block-tol", value, 1, true, &solve->block_tolerance);
    case CLI_OPTION_DIRECT:
        settings->direct_given = true;
        return take_direct(value, &solve->direct);
    case CLI_OPTION_ENVIRONMENT:
        return cli_take_environment(value, &settings->environment);
    case CLI_OPTION_SOLVER:
        return take_solver(value, &solve->solver);
    case CLI_OPTION_MAX_SWEEPS:
        return cli_integer("--max-sweeps", value, 1, INT_MAX, &solve->max_sweeps);
    case CLI_OPTION_MAX_REFLECTANCE:
        return cli_positive("--max-reflectance", value, 1, false, &read->max_reflectance);
    case CLI_OPTION_METALLIC:
        return take_metallic(value, &read->metallic_black);
    case CLI_OPTION_SCENE_INDEX:
        return cli_integer("--scene-index", value, 0, INT_MAX, &read->scene_index);
    case CLI_OPTION_REPORT:
        return cli_path("--report", value, &settings->report_path);
    case CLI_OPTION_TOLERANCE:
        return cli_positive("--tol", value, 1, true, &solve->tolerance);
    case CLI_OPTION_REFINE:
        settings->refine_given = true;
        return take_refine(value, &solve->refine);
    case CLI_OPTION_MAX_TIME:
        return cli_positive("--max-time", value, INFINITY, false, &solve->max_seconds);
    case CLI_OPTION_MAX_MEMORY:
        return take_bytes("--max-memory", value, &solve->max_bytes);
    default:
        return -1;
    }
}

static bool take_isa(cli_run *run, const char *text)
{
    static const char *const names[] = {"auto", "sse2", "avx2", "avx512"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (!strcmp(text, names[i])) {
            run->isa = names[i];
            return true;
        }
    }
    cli_complain("--isa '%s': expected auto, sse2, avx2 or avx512", text);
    return false;
}

int cli_take_common_option(cli_run *run, int id, const char *value)
{
    switch (id) {
    case CLI_OPTION_THREADS:
        return cli_integer("--threads", value, 1, CLI_MAX_THREADS, &run->threads);
    case CLI_OPTION_ISA:
        return take_isa(run, value);
    case CLI_OPTION_QUIET:
        return run->quiet = true;
    case CLI_OPTION_VERBOSE:
        return run->verbose = true;
    default:
        return -1;
    }
}
