// One triangle over the whole history, with what is the same for all of its pixels.
#include "csm_history.h"
#include "private/history_inputs.hlsl"

cbuffer history_block : register(b0)
{
    float4 history_c[CSM_H_COUNT];
};

history_inputs main(uint vertex : SV_VertexID)
{
    history_inputs o;
    o.position = float4(vertex == 1 ? 3.0 : -1.0, vertex == 2 ? 3.0 : -1.0, 0.0, 1.0);
    o.place_0 = history_c[CSM_H_PLACE];
    o.place_1 = history_c[CSM_H_PLACE + 1];
    o.place_2 = history_c[CSM_H_PLACE + 2];
    o.place_3 = history_c[CSM_H_PLACE + 3];
    o.plane_0 = history_c[CSM_H_PLANE];
    o.plane_1 = history_c[CSM_H_PLANE + 1];
    o.plane_2 = history_c[CSM_H_PLANE + 2];
    o.normal_0 = history_c[CSM_H_NORMAL];
    o.normal_1 = history_c[CSM_H_NORMAL + 1];
    o.normal_2 = history_c[CSM_H_NORMAL + 2];
    o.own = history_c[CSM_H_OWN];
    o.size = history_c[CSM_H_SIZE];
    o.limits = history_c[CSM_H_LIMITS];
    o.clear = history_c[CSM_H_CLEAR];
    o.noise = history_c[CSM_H_NOISE];
    return o;
}
