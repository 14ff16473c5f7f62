#include "abi/context.h"

csm_result context_usable(csm_context *context) {
  return context_device(context)->lost ? host_fail(&context->host, CSM_ERROR_DEVICE_LOST, "the device was lost")
                                       : CSM_SUCCESS;
}

const char *CSM_CALL csm_last_error(const csm_context *context) {
  return context ? context->host.error : "";
}
