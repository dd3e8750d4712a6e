#ifndef HPRAD_STATUS_H
#define HPRAD_STATUS_H

#if defined(__GNUC__)
#define HPR_API __attribute__((visibility("default")))
#else
#define HPR_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** What a fallible call returns. The text that belongs to it stands on the context. */
typedef enum hpr_status {
    HPR_OK = 0,
    HPR_ERR_ARG,         /**< a bad argument of the call itself */
    HPR_ERR_MEMORY,      /**< out of memory, or a predicted size above the limit */
    HPR_ERR_IO,          /**< a file that cannot be read or written */
    HPR_ERR_FORMAT,      /**< an input file that breaks its format, or a scene that makes no sense */
    HPR_ERR_UNSUPPORTED, /**< a valid input that needs something hprad does not have */
    HPR_ERR_NUMERIC,     /**< no finite solution, or an iteration that does not converge */
    HPR_ERR_TOLERANCE,   /**< finished, but less accurate than asked */
    HPR_ERR_INTERRUPTED, /**< cancelled through the context */
    HPR_ERR_DEVICE       /**< Embree or the machine refused */
} hpr_status;

/** A static English text for a status; never NULL. Thread-safe. */
HPR_API const char *hpr_status_string(hpr_status status);

#ifdef __cplusplus
}
#endif

#endif
