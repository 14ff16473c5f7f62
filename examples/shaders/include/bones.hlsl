// bones.hlsl: linear blend skinning with two bones, weighted by height. The block is draw_constants of world.h.
cbuffer draw_block : register(b2)
{
    float4 bones[6]; // rows of two affine matrices
    float4 surface;  // colour, weight of the second bone for each metre of height
};

// One chain of mad with the constant innermost: the same bits from every compiler, so that a thing's depth is the same
// in each pass that draws it.
float row(float4 r, float3 p)
{
    return mad(p.x, r.x, mad(p.y, r.y, mad(p.z, r.z, r.w)));
}

float row_direction(float4 r, float3 v)
{
    return mad(v.x, r.x, mad(v.y, r.y, v.z * r.z));
}

float3 blend(float3 a, float3 b, float weight)
{
    return float3(mad(weight, b.x - a.x, a.x), mad(weight, b.y - a.y, a.y), mad(weight, b.z - a.z, a.z));
}

float bone_weight(float3 p)
{
    return clamp(p.y * surface.w, 0.0, 1.0);
}

float3 bent_position(float3 p)
{
    return blend(float3(row(bones[0], p), row(bones[1], p), row(bones[2], p)),
                 float3(row(bones[3], p), row(bones[4], p), row(bones[5], p)), bone_weight(p));
}

// Right for turns, and for normals along the axes of a scale, which is all that this world has.
float3 bent_normal(float3 n, float3 p)
{
    return blend(float3(row_direction(bones[0], n), row_direction(bones[1], n), row_direction(bones[2], n)),
                 float3(row_direction(bones[3], n), row_direction(bones[4], n), row_direction(bones[5], n)),
                 bone_weight(p));
}
