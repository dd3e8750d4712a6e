#ifndef HPRAD_VERSION_H
#define HPRAD_VERSION_H

#include <hprad/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Version of the library, such as "0.1.0". Static text. */
HPR_API const char *hpr_version(void);

/** Commit that it was built from, "-dirty" appended if files were changed; "unknown" outside git. Static
 * text. */
HPR_API const char *hpr_commit(void);

/** Version of the Embree that it was built with, such as "3.13.5". Static text. */
HPR_API const char *hpr_embree_version(void);

#ifdef __cplusplus
}
#endif

#endif
