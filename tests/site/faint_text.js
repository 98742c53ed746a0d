// Text whose contrast is too low, among the first sixty elements of each kind. Colours and ratio as in WCAG 2.2.
([enough, enoughLarge]) => {
  const channels = colour => colour.match(/[\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b].map(c => c / 255).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const over = (top, under) => { const a = top.length > 3 ? top[3] : 1; return [0, 1, 2].map(i => a * top[i] + (1 - a) * under[i]); };
  const behind = element => {
    const layers = [];
    for (let one = element; one; one = one.parentElement) layers.unshift(channels(getComputedStyle(one).backgroundColor));
    return layers.reduce((under, top) => over(top, under), [255, 255, 255]);
  };
  const kinds = ['h1', 'h2', 'p', 'li', 'a', 'td', 'th', 'code', 'pre', 'pre span', 'dt', 'dt span', '.sidebar-drawer a', 'footer div', '.sd-card-title'];
  const faint = [];
  for (const kind of kinds) for (const element of [...document.querySelectorAll(kind)].slice(0, 60)) {
    const text = [...element.childNodes].filter(n => n.nodeType === 3).map(n => n.textContent.trim()).join('');
    if (!text || !element.checkVisibility({visibilityProperty: true, opacityProperty: true})) continue;
    const style = getComputedStyle(element), under = behind(element), ink = over(channels(style.color), under);
    const [a, b] = [light(ink), light(under)], contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && parseInt(style.fontWeight) >= 700);
    if (contrast < (large ? enoughLarge : enough)) faint.push([kind, text.slice(0, 40), Math.round(100 * contrast) / 100]);
  }
  return faint;
}
