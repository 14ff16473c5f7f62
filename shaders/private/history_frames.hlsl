// How many frames a pixel is the mean of, 0 to 64, and how flat that is (csm_flatness), in 62 steps: an integer that a half
// holds.
float flatness_step(float code)
{
    return floor((code - CSM_H_NO_FRAMES + 0.5) * (1.0 / 65.0));
}

float decode_flatness(float code)
{
    return flatness_step(code) * (1.0 / 62.0);
}

float decode_frames(float code)
{
    return mad(flatness_step(code), -65.0, code - CSM_H_NO_FRAMES);
}
