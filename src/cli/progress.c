/* The bar on a terminal: one line on stderr, redrawn a few times per second. */
#include "cli/cli.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { BAR_WIDTH = 30 };

static const double redraw_seconds = 0.1;

static double seconds_between(const struct timespec *start, const struct timespec *end)
{
    return (double)(end->tv_sec - start->tv_sec) + 1e-9 * (double)(end->tv_nsec - start->tv_nsec);
}

void cli_clear_progress(cli_run *run)
{
    if (run->progress.drawn)
        fputs("\r\033[K", stderr);
    run->progress.drawn = false;
}

/* The stage's remaining time if it goes on as before; nothing before there is something to go by. */
static void format_eta(double elapsed, double fraction, char *text, size_t bytes)
{
    double left = fraction > 0 ? elapsed * (1 - fraction) / fraction + 0.5 : INFINITY;
    if (elapsed >= 1 && fraction >= 0.01 && left < 360000)
        snprintf(text, bytes, "  ETA %d:%02d:%02d", (int)left / 3600, (int)left / 60 % 60, (int)left % 60);
}

void cli_show_accuracy(void *user, double error, double tolerance)
{
    cli_run *run = user;
    run->progress.error = error;
    run->progress.tolerance = tolerance;
}

void cli_show_progress(void *user, const char *stage, double fraction)
{
    cli_run *run = user;
    cli_progress *progress = &run->progress;
    if (!progress->wanted)
        return;
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (!progress->stage || strcmp(stage, progress->stage)) {
        progress->stage = stage;
        progress->stage_start = now;
        progress->last_drawn = (struct timespec){0};
    }
    if (fraction >= 1) {
        cli_clear_progress(run);
        progress->stage = NULL;
        return;
    }
    if (seconds_between(&progress->last_drawn, &now) < redraw_seconds)
        return;
    progress->last_drawn = now;
    progress->drawn = true;
    char eta[32] = "", accuracy[48] = "";
    format_eta(seconds_between(&progress->stage_start, &now), fraction, eta, sizeof eta);
    if (progress->tolerance > 0)
        snprintf(accuracy, sizeof accuracy, "  error %.1e of %.1e", progress->error, progress->tolerance);
    int full = (int)(fraction * BAR_WIDTH);
    fprintf(stderr, "\r\033[K%-12.12s [%.*s%*s] %3d%%%s%s", stage, full, "##############################",
            BAR_WIDTH - full, "", (int)(100 * fraction), accuracy, eta);
    fflush(stderr);
}
