/*
 * rig_d3d12_faults.h: an ID3D12Device that forwards to another, counts the calls that can fail, and fails one of them
 * (rig_fail). It has the methods that csm needs; any other is a crash. There is one in a program.
 */
#ifndef RIG_D3D12_FAULTS_H
#define RIG_D3D12_FAULTS_H

#include "rig_d3d12.h"

/* The device that csm gets in place of `real`. */
ID3D12Device *d3d12_faults_open(ID3D12Device *real);
/* Lets the device say that this is its highest feature level; 0 asks the real one. */
void d3d12_faults_level(D3D_FEATURE_LEVEL level);

#endif
