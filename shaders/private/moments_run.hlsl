// A blur along one axis: a thread makes a run of eight texels. Includers define MOMENTS_READ(i): texel i of the run's line,
// which is clamped to the line's ends.
//
// A blurred texel is what it was, and what the others differ from it: where all are alike, it is none other than they are.
struct moments_run
{
    MOMENTS a, b, c, d, e, f, g, h;
};

#if MOMENTS_SMALL
static float3 moments_weights; // one texel away, two, three

MOMENTS blurred(MOMENTS a, MOMENTS b, MOMENTS c, MOMENTS middle, MOMENTS d, MOMENTS e, MOMENTS f)
{
    MOMENTS outer = mad(moments_weights.z, (a - middle) + (f - middle), middle);
    return mad(moments_weights.x, (c - middle) + (d - middle),
               mad(moments_weights.y, (b - middle) + (e - middle), outer));
}

moments_run blurred_run(int begin, int radius)
{
    moments_weights = float3(moments_c[MOMENTS_WEIGHTS + radius + 1].x, moments_c[MOMENTS_WEIGHTS + radius + 2].x,
                             moments_c[MOMENTS_WEIGHTS + radius + 3].x);
    MOMENTS m0 = MOMENTS_READ(begin - 3), m1 = MOMENTS_READ(begin - 2), m2 = MOMENTS_READ(begin - 1);
    MOMENTS m3 = MOMENTS_READ(begin), m4 = MOMENTS_READ(begin + 1), m5 = MOMENTS_READ(begin + 2);
    MOMENTS m6 = MOMENTS_READ(begin + 3), m7 = MOMENTS_READ(begin + 4), m8 = MOMENTS_READ(begin + 5);
    MOMENTS m9 = MOMENTS_READ(begin + 6), m10 = MOMENTS_READ(begin + 7), m11 = MOMENTS_READ(begin + 8);
    MOMENTS m12 = MOMENTS_READ(begin + 9), m13 = MOMENTS_READ(begin + 10);
    moments_run run;
    run.a = blurred(m0, m1, m2, m3, m4, m5, m6);
    run.b = blurred(m1, m2, m3, m4, m5, m6, m7);
    run.c = blurred(m2, m3, m4, m5, m6, m7, m8);
    run.d = blurred(m3, m4, m5, m6, m7, m8, m9);
    run.e = blurred(m4, m5, m6, m7, m8, m9, m10);
    run.f = blurred(m5, m6, m7, m8, m9, m10, m11);
    run.g = blurred(m6, m7, m8, m9, m10, m11, m12);
    run.h = blurred(m7, m8, m9, m10, m11, m12, m13);
    return run;
}
#else
// Each texel that is read goes to all eight, with the weight that it has there.
moments_run blurred_run(int begin, int radius)
{
    MOMENTS a = MOMENTS_READ(begin), b = MOMENTS_READ(begin + 1), c = MOMENTS_READ(begin + 2);
    MOMENTS d = MOMENTS_READ(begin + 3), e = MOMENTS_READ(begin + 4), f = MOMENTS_READ(begin + 5);
    MOMENTS g = MOMENTS_READ(begin + 6), h = MOMENTS_READ(begin + 7);
    MOMENTS none = MOMENTS_OF(float4(0.0, 0.0, 0.0, 0.0));
    moments_run run; // what others differ, first
    run.a = none;
    run.b = none;
    run.c = none;
    run.d = none;
    run.e = none;
    run.f = none;
    run.g = none;
    run.h = none;
    float wa = 0.0, wb = 0.0, wc = 0.0, wd = 0.0, we = 0.0, wf = 0.0, wg = 0.0, wh = 0.0;
    int count = 2 * radius + MOMENTS_RUN;
    [loop] for (int i = 0; i < count; ++i)
    {
        MOMENTS read = MOMENTS_READ(begin + i - radius);
        wh = wg;
        wg = wf;
        wf = we;
        we = wd;
        wd = wc;
        wc = wb;
        wb = wa;
        wa = moments_c[MOMENTS_WEIGHTS + i].x;
        run.a = mad(wa, read - a, run.a);
        run.b = mad(wb, read - b, run.b);
        run.c = mad(wc, read - c, run.c);
        run.d = mad(wd, read - d, run.d);
        run.e = mad(we, read - e, run.e);
        run.f = mad(wf, read - f, run.f);
        run.g = mad(wg, read - g, run.g);
        run.h = mad(wh, read - h, run.h);
    }
    run.a = a + run.a;
    run.b = b + run.b;
    run.c = c + run.c;
    run.d = d + run.d;
    run.e = e + run.e;
    run.f = f + run.f;
    run.g = g + run.g;
    run.h = h + run.h;
    return run;
}
#endif
