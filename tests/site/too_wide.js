// What runs off the page on its right: how far the page scrolls, and what is cut and stands in no box that scrolls.
() => {
  const page = document.documentElement;
  const scrolls = element => {
    for (let one = element; one && one.tagName !== 'ARTICLE'; one = one.parentElement)
      if (['auto', 'scroll'].includes(getComputedStyle(one).overflowX) && one.scrollWidth > one.clientWidth) return true;
    return false;
  };
  const cut = [...document.querySelectorAll('article *, body > div:not([class]), footer *')].filter(element => {
    const place = element.getBoundingClientRect();
    return place.width > 0 && place.right > page.clientWidth + 1 && element.checkVisibility() && !scrolls(element);
  });
  const over = page.scrollWidth - page.clientWidth;
  const told = cut.slice(0, 3).map(element => `${element.tagName}: ${element.textContent.slice(0, 40)}`);
  return (over > 0 ? [`page: ${over}`] : []).concat(told);
}
