#include "abi/context.h"

#include <stdarg.h>
#include <stdio.h>

csm_result context_fail(csm_context *context, csm_result result, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(context->error, sizeof context->error, format, arguments);
  va_end(arguments);
  context->log(context->user, CSM_LOG_ERROR, context->error);
  return result;
}

csm_result device_check(device *device, csm_result result, const char *what) {
  if (!result)
    return CSM_SUCCESS;
  device->lost |= result == CSM_ERROR_DEVICE_LOST;
  return context_fail(device->context, result, "%s: %s", what, csm_result_name(result));
}

csm_result context_check_struct(csm_context *context, csm_result result, const char *name) {
  if (result == CSM_ERROR_NULL_POINTER)
    return context_fail(context, result, "%s is NULL", name);
  if (result)
    return context_fail(context, result,
                        "%s has a struct_size that is not its size in any version, or a tail that this version does "
                        "not know and that is not zero",
                        name);
  return CSM_SUCCESS;
}

csm_result context_usable(csm_context *context) {
  return context->device->lost ? context_fail(context, CSM_ERROR_DEVICE_LOST, "the device was lost") : CSM_SUCCESS;
}

const char *CSM_CALL csm_last_error(const csm_context *context) {
  return context ? context->error : "";
}
