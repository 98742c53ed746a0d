#pragma once
// What the compiler cannot know: the hot loop gains from these.
#ifdef _MSC_VER
#define COGGING_INLINE __forceinline
#define COGGING_NOINLINE __declspec(noinline)
#define COGGING_COLD __declspec(noinline)
#define COGGING_INLINE_LAMBDA [[msvc::forceinline]]
#else
#define COGGING_INLINE inline __attribute__((always_inline))
#define COGGING_NOINLINE __attribute__((noinline))
#define COGGING_COLD __attribute__((noinline, cold))
#define COGGING_INLINE_LAMBDA __attribute__((always_inline))
#endif
