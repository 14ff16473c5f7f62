/* headers.h: the headers of Direct3D 12, which are those of vkd3d here. On Windows they are the system's. */
#ifndef D3D12_HEADERS_H
#define D3D12_HEADERS_H

#define COBJMACROS
#define WIDL_C_INLINE_WRAPPERS
#include <vkd3d_windows.h>
/* after the types that it uses */
#include <vkd3d_d3d12.h>

#endif
