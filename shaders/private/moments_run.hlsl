// A blur of any radius along one axis: a thread makes a run of eight texels. Each texel that it reads goes to all eight of
// them, with the weight that it has there. Includers define MOMENTS_READ(i): the texel i of the run's line, clamped.
//
// A texel is the middle, and what the others differ from it: where all are alike, it is none other than they are.

struct run_of_eight
{
    MOMENTS a, b, c, d, e, f, g, h;
};

run_of_eight blurred_run(int begin, int radius)
{
    MOMENTS a = MOMENTS_READ(begin), b = MOMENTS_READ(begin + 1), c = MOMENTS_READ(begin + 2);
    MOMENTS d = MOMENTS_READ(begin + 3), e = MOMENTS_READ(begin + 4), f = MOMENTS_READ(begin + 5);
    MOMENTS g = MOMENTS_READ(begin + 6), h = MOMENTS_READ(begin + 7);
    run_of_eight sum;
    sum.a = a;
    sum.b = b;
    sum.c = c;
    sum.d = d;
    sum.e = e;
    sum.f = f;
    sum.g = g;
    sum.h = h;
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
        sum.a = mad(wa, read - a, sum.a);
        sum.b = mad(wb, read - b, sum.b);
        sum.c = mad(wc, read - c, sum.c);
        sum.d = mad(wd, read - d, sum.d);
        sum.e = mad(we, read - e, sum.e);
        sum.f = mad(wf, read - f, sum.f);
        sum.g = mad(wg, read - g, sum.g);
        sum.h = mad(wh, read - h, sum.h);
    }
    return sum;
}
