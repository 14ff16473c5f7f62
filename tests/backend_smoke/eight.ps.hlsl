/* Eight textures, each with a weight of its own. */
Texture2D<float> t0_ : register(t0);
Texture2D<float> t1_ : register(t1);
Texture2D<float> t2_ : register(t2);
Texture2D<float> t3_ : register(t3);
Texture2D<float> t4_ : register(t4);
Texture2D<float> t5_ : register(t5);
Texture2D<float> t6_ : register(t6);
Texture2D<float> t7_ : register(t7);

float4 main(float4 position : SV_Position) : SV_Target {
  int3 at = int3(int2(position.xy), 0);
  float low = t0_.Load(at) + 10 * t1_.Load(at) + 100 * t2_.Load(at) + 1000 * t3_.Load(at);
  float high = t4_.Load(at) + 10 * t5_.Load(at) + 100 * t6_.Load(at) + 1000 * t7_.Load(at);
  return float4(low, high, 0, 0);
}
