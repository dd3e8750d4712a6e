#include "version_values.h"

#include <hprad/version.h>

const char *hpr_version(void)
{
    return HPR_VERSION;
}

const char *hpr_commit(void)
{
    return HPR_COMMIT;
}
