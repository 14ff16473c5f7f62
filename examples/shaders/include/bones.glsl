// bones.glsl: linear blend skinning with two bones, weighted by height. The block is draw_constants of world.h.
layout(push_constant) uniform draw_block
{
    vec4 bones[6]; // rows of two affine matrices
    vec4 surface;  // colour, weight of the second bone for each metre of height
};

// One chain of fma with the constant innermost: the same bits from every compiler, so that a thing's depth is the same
// in each pass that draws it.
float row(vec4 r, vec3 p)
{
    return fma(p.x, r.x, fma(p.y, r.y, fma(p.z, r.z, r.w)));
}

float row_direction(vec4 r, vec3 v)
{
    return fma(v.x, r.x, fma(v.y, r.y, v.z * r.z));
}

vec3 blend(vec3 a, vec3 b, float weight)
{
    return vec3(fma(weight, b.x - a.x, a.x), fma(weight, b.y - a.y, a.y), fma(weight, b.z - a.z, a.z));
}

float bone_weight(vec3 p)
{
    return clamp(p.y * surface.w, 0.0, 1.0);
}

vec3 bent_position(vec3 p)
{
    return blend(vec3(row(bones[0], p), row(bones[1], p), row(bones[2], p)),
                 vec3(row(bones[3], p), row(bones[4], p), row(bones[5], p)), bone_weight(p));
}

// Right for turns, and for normals along the axes of a scale, which is all that this world has.
vec3 bent_normal(vec3 n, vec3 p)
{
    return blend(vec3(row_direction(bones[0], n), row_direction(bones[1], n), row_direction(bones[2], n)),
                 vec3(row_direction(bones[3], n), row_direction(bones[4], n), row_direction(bones[5], n)),
                 bone_weight(p));
}
