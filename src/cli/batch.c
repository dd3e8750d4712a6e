/* hprad batch */
#include "cli/cli.h"

#include <ctype.h>
#include <hprad/batch.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { OPTION_JOBS = CLI_OPTION_OWN, OPTION_MEMORY, OPTION_SHARD, OPTION_DRY_RUN };

static const struct poptOption options[] = {
    {"jobs", 'j', POPT_ARG_STRING, NULL, OPTION_JOBS,
     "jobs at a time, which share threads and memory (default 1)", "N"},
    {"memory", 0, POPT_ARG_STRING, NULL, OPTION_MEMORY,
     "for all jobs together, in GB (default: nine tenths of the machine's)", "GB"},
    {"shard", 0, POPT_ARG_STRING, NULL, OPTION_SHARD,
     "only the i-th of n parts of the work, from 1; a part for each machine", "i/n"},
    {"dry-run", 0, POPT_ARG_NONE, NULL, OPTION_DRY_RUN,
     "say what would be done and what is there, do nothing", NULL},
    {NULL, 0, POPT_ARG_INCLUDE_TABLE, (void *)cli_common_options, 0, "Common:", NULL},
    POPT_TABLEEND};

static bool take_shard(const char *text, hpr_batch_options *chosen)
{
    int end = 0;
    bool plain = isdigit((unsigned char)text[0]) && strlen(text) < 20 && !text[strspn(text, "0123456789/")];
    if (plain && sscanf(text, "%d/%d%n", &chosen->shard, &chosen->shard_count, &end) == 2 && !text[end] &&
        chosen->shard >= 1 && chosen->shard <= chosen->shard_count)
        return true;
    cli_complain("--shard '%s': expected i/n with 1 <= i <= n, such as 1/8", text);
    return false;
}

static bool take(void *user, int id, const char *value)
{
    hpr_batch_options *chosen = user;
    switch (id) {
    case OPTION_JOBS:
        return cli_integer("--jobs", value, 1, CLI_MAX_THREADS, &chosen->jobs);
    case OPTION_MEMORY:
        if (!cli_positive("--memory", value, 1e6, false, &chosen->memory_bytes))
            return false;
        chosen->memory_bytes *= 1e9;
        return true;
    case OPTION_SHARD:
        return take_shard(value, chosen);
    default:
        chosen->dry_run = 1;
        return true;
    }
}

static const cli_verb verb = {
    .name = "hprad batch",
    .operands = "JOBS.json [OPTIONS]",
    .about =
        "Many scenes, many settings, many views: solves every scene once at every setting and renders every\n"
        "camera of each solution, as the batch file asks for (its keys: README). What is finished stands in\n"
        "FOLDER/manifest.jsonl with its hash; the same command again makes only what is missing, also after\n"
        "a kill. Exit codes: 1 if a job failed (the others are done), 4 if a tolerance was missed at "
        "worst.\n",
    .examples = "  hprad batch jobs.json --jobs 4 --memory 16\n"
                "  hprad batch jobs.json --dry-run\n"
                "  sbatch --array=1-8 --wrap 'hprad batch jobs.json --shard $SLURM_ARRAY_TASK_ID/8'\n"
                "  parallel -S host1,host2 --wd . hprad batch jobs.json --shard {}/2 ::: 1 2\n",
    .operand_count = 1,
    .operand_names = "one batch file",
    .options = options,
    .take = take,
};

static void say(void *user, const hpr_batch_event *event)
{
    cli_run *run = user;
    switch (event->kind) {
    case HPR_BATCH_FAILED:
        cli_complain("%s: %s", event->path, event->text);
        return;
    case HPR_BATCH_LEFT_OUT:
        cli_complain("%s: left out, %s", event->path, event->text);
        return;
    default:
        break;
    }
    if (run->quiet)
        return;
    if (event->kind == HPR_BATCH_WROTE)
        printf("wrote %s\n", event->path);
    else
        printf("%s %s\n", event->reused ? "is there" : "to make ", event->path);
    fflush(stdout);
}

static void print_summary(const hpr_batch_result *result)
{
    printf("solutions %zu solved, %zu reused\n", result->solved, result->solutions_reused);
    printf("pictures  %zu made, %zu reused, %zu left out\n", result->pictures, result->pictures_reused,
           result->left_out);
    printf("jobs      %zu failed, %zu missed their tolerance\n", result->failed, result->missed);
}

int cli_batch(int argc, const char **argv)
{
    hpr_batch_options chosen;
    hpr_batch_options_init(&chosen);
    cli_run run;
    int code = cli_parse(&run, &verb, &chosen, argc, argv);
    if (code == CLI_GO_ON)
        code = cli_open(&run);
    if (code == CLI_GO_ON) {
        chosen.said = say;
        chosen.user = &run;
        hpr_batch_result result;
        hpr_status status = hpr_job_batch(run.context, run.operand[0], &chosen, &result);
        /* An I/O error before a batch begins is that of its file. */
        code = cli_conclude(&run, status, HPR_JOB_READ);
        if (status == HPR_OK && !run.quiet && !chosen.dry_run)
            print_summary(&result);
        if (status == HPR_OK && result.failed)
            code = CLI_FAILED;
        else if (status == HPR_OK && result.missed)
            code = CLI_TOLERANCE;
    }
    cli_finish(&run);
    return code;
}
