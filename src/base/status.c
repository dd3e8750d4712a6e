#include <hprad/status.h>

const char *hpr_status_string(hpr_status status)
{
    switch (status) {
    case HPR_OK:
        return "ok";
    case HPR_ERR_ARG:
        return "bad argument";
    case HPR_ERR_MEMORY:
        return "out of memory";
    case HPR_ERR_IO:
        return "input or output failed";
    case HPR_ERR_FORMAT:
        return "bad input";
    case HPR_ERR_UNSUPPORTED:
        return "not supported";
    case HPR_ERR_NUMERIC:
        return "no convergence";
    case HPR_ERR_TOLERANCE:
        return "tolerance not reached";
    case HPR_ERR_INTERRUPTED:
        return "interrupted";
    case HPR_ERR_DEVICE:
        return "device error";
    }
    return "unknown status";
}
