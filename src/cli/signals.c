/* The first SIGINT or SIGTERM asks the running job to stop; a second one of the kind kills. */
#include "cli/cli.h"

#include <signal.h>

volatile sig_atomic_t cli_signal;

static void note_signal(int number)
{
    cli_signal = number;
}

void cli_catch_signals(void)
{
    struct sigaction action = {.sa_handler = note_signal, .sa_flags = (int)SA_RESETHAND};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}
