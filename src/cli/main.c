/* Finds the verb; the form without one is a verb too. */
#include "cli/cli.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const struct {
    const char *name, *full_name;
    cli_function run;
} verbs[] = {
    {"solve", "hprad solve", cli_solve},
    {"render", "hprad render", cli_render},
    {"probe", "hprad probe", cli_probe},
    {"formfactors", "hprad formfactors", cli_formfactors},
    {"reference", "hprad reference", cli_reference},
    {"study", "hprad study", cli_study},
    {"plan", "hprad plan", cli_plan},
    {"batch", "hprad batch", cli_batch},
};

enum { VERB_COUNT = sizeof verbs / sizeof *verbs };

cli_function cli_find_verb(const char *name)
{
    for (int i = 0; i < VERB_COUNT; i++) {
        if (!strcmp(name, verbs[i].name))
            return verbs[i].run;
    }
    return NULL;
}

static int dispatch(int argc, const char **argv)
{
    for (int i = 0; argc > 1 && i < VERB_COUNT; i++) {
        if (!strcmp(argv[1], verbs[i].name)) {
            argv[1] = verbs[i].full_name; /* help prints it */
            return verbs[i].run(argc - 1, argv + 1);
        }
    }
    if (argc > 0)
        argv[0] = "hprad";
    return cli_picture(argc, argv);
}

int main(int argc, char **argv)
{
    /* Room for all of --help: what a write in between had to say would be lost. */
    static char buffer[1 << 16];
    if (!isatty(STDOUT_FILENO))
        setvbuf(stdout, buffer, _IOFBF, sizeof buffer);
    int code = dispatch(argc, (const char **)argv);
    /* A result that did not reach its reader is no result. */
    errno = 0;
    if ((fflush(stdout) || ferror(stdout)) && code == CLI_DONE) {
        cli_complain("cannot write standard output: %s", errno ? strerror(errno) : "write error");
        code = CLI_FAILED;
    }
    return code;
}
