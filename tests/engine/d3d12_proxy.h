/*
 * d3d12_proxy.h: an ID3D12Device that forwards to another, counts the calls that can fail, and fails one of them. It
 * has the methods that csm needs; any other is a crash.
 */
#ifndef D3D12_PROXY_H
#define D3D12_PROXY_H

#include "d3d12_engine.h"

typedef struct d3d12_proxy {
  ID3D12Device device; /* what csm gets */
  ID3D12Device *real;
  uint32_t references;
  uint32_t calls;   /* that can fail, so far */
  uint32_t fail_at; /* the call that fails, from 1; 0: none */
  HRESULT failure;
  bool removed;                 /* the device said that it was lost, and goes on saying so */
  D3D_FEATURE_LEVEL level;      /* the highest; 0 asks the real one */
  uint32_t queues, list_makers; /* command queues, and lists or allocators, that were made */
} d3d12_proxy;

void d3d12_proxy_open(d3d12_proxy *proxy, ID3D12Device *real);

#endif
